#include "server/rpc/item_bucket.h"

#include <gtest/gtest.h>

namespace lucerna::access {
namespace {

using std::chrono::milliseconds;

const ItemBucket::Clock::time_point kStart = ItemBucket::Clock::time_point(std::chrono::hours(1));

ItemBucket::Clock::time_point at(int ms) { return kStart + milliseconds(ms); }

TEST(ItemBucket, HoldsTheItemsOfOneSecond) {
  ItemBucket bucket;
  EXPECT_EQ(bucket.take(60, 100, at(0)).count(), 0);
  EXPECT_EQ(bucket.take(40, 100, at(0)).count(), 0);
  // Empty: one item takes 10 ms, 25 items take 250 ms.
  EXPECT_EQ(bucket.take(1, 100, at(0)).count(), 10);
  EXPECT_EQ(bucket.take(25, 100, at(0)).count(), 250);
}

TEST(ItemBucket, SaysExactlyWhenEnoughAreThere) {
  ItemBucket bucket;
  EXPECT_EQ(bucket.take(100, 100, at(0)).count(), 0);
  EXPECT_EQ(bucket.take(25, 100, at(100)).count(), 150);
  EXPECT_EQ(bucket.take(25, 100, at(249)).count(), 1);
  EXPECT_EQ(bucket.take(25, 100, at(250)).count(), 0);
  EXPECT_EQ(bucket.take(1, 100, at(250)).count(), 10);
}

TEST(ItemBucket, DoesNotSaveMoreThanASecond) {
  ItemBucket bucket;
  EXPECT_EQ(bucket.take(100, 100, at(0)).count(), 0);
  EXPECT_EQ(bucket.take(100, 100, at(60'000)).count(), 0);
  EXPECT_EQ(bucket.take(1, 100, at(60'000)).count(), 10);
}

TEST(ItemBucket, WhatWasComputedIsMadeUpForByLaterRequests) {
  ItemBucket bucket;
  EXPECT_EQ(bucket.take(1, 100, at(0)).count(), 0);
  bucket.owe(274);
  EXPECT_EQ(bucket.take(25, 100, at(0)).count(), 2000);
  EXPECT_EQ(bucket.take(25, 100, at(2000)).count(), 0);
}

TEST(ItemBucket, ARequestLargerThanTheBucketNeedsAFullOne) {
  ItemBucket bucket;
  EXPECT_EQ(bucket.take(1, 100, at(0)).count(), 0);
  EXPECT_EQ(bucket.take(1000, 100, at(0)).count(), 10);
  EXPECT_EQ(bucket.take(1000, 100, at(10)).count(), 0);
  // Its debt is 10 s, and one item more takes 10 ms.
  EXPECT_EQ(bucket.take(1, 100, at(10)).count(), 9010);
  EXPECT_EQ(bucket.take(1, 100, at(9020)).count(), 0);
}

TEST(ItemBucket, ARefusalTakesNothing) {
  ItemBucket bucket;
  EXPECT_EQ(bucket.take(90, 100, at(0)).count(), 0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(bucket.take(20, 100, at(0)).count(), 100);
  EXPECT_EQ(bucket.take(10, 100, at(0)).count(), 0);
}

TEST(ItemBucket, HasNoLimitWithoutARate) {
  ItemBucket bucket;
  EXPECT_EQ(bucket.take(1'000'000'000'000, 0, at(0)).count(), 0);
  EXPECT_EQ(bucket.take(100, 100, at(0)).count(), 0);
  EXPECT_EQ(bucket.take(0, 100, at(0)).count(), 0);
}

}  // namespace
}  // namespace lucerna::access
