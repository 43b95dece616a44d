// Makes calls with the C++ client, one for each line of standard input, and prints their times.
// tests/bench/python_client.py runs it in turns with the Python package.
//
//     client_calls HOST:PORT SCENE_ID POINTS
//
// A line is irradiance, sample_li, pdf_li, le or visible.  The answer is "WALL_S PROCESSOR_S SUM":
// the time of the call, the processor time of this process, and the sum of an array of the answer.
#include <fmt/core.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "lucerna/client/batches.h"
#include "lucerna/client/points.h"

namespace lucerna {
namespace {

using client::Double3;

template <typename T>
T value(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

double sum(const google::protobuf::RepeatedField<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double processor_s() {
  timespec time;
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The points of a square 0.1 m above the floor, x first.
std::vector<Double3> make_receivers(int count) {
  std::vector<Double3> points;
  for (int i = 0; i < count; ++i)
    points.push_back({-2 + 4 * (i % 128 + 0.5) / 128, -2 + 4 * (i / 128 + 0.5) / 128, 0.1});
  return points;
}

double call(const client::Client& client, const std::string& scene, const std::string& what,
            const std::vector<Double3>& points) {
  const std::vector<Double3> up(points.size(), Double3{0, 0, 1});
  if (what == "irradiance") {
    v1::EstimateIrradianceRequest request;
    request.set_scene_id(scene);
    *request.mutable_receivers() = client::make_points(points);
    client::fill(up, request.mutable_normals());
    request.mutable_accuracy()->set_samples(1);
    request.set_bounces(0);
    return sum(value(client::estimate_irradiance_in_batches(client, request)).illuminance_lx());
  }
  if (what == "sample_li") {
    v1::SampleLiRequest request;
    request.set_scene_id(scene);
    *request.mutable_receivers() = client::make_points(points);
    return sum(value(client::sample_li_in_batches(client, request)).value());
  }
  if (what == "pdf_li") {
    v1::PdfLiRequest request;
    request.set_scene_id(scene);
    *request.mutable_receivers() = client::make_points(points);
    client::fill(up, request.mutable_wi());
    request.set_light_id(1);
    return sum(value(client::pdf_li_in_batches(client, request)).pdf_per_sr());
  }
  if (what == "le") {
    v1::LeRequest request;
    request.set_scene_id(scene);
    *request.mutable_points() = client::make_points(points);
    client::fill(up, request.mutable_directions());
    return sum(value(client::le_in_batches(client, request)).radiance_cd_m2());
  }
  v1::TestVisibilityRequest request;
  request.set_scene_id(scene);
  *request.mutable_rays()->mutable_from() = client::make_points(points);
  client::fill(up, request.mutable_rays()->mutable_directions());
  return value(client::test_visibility_in_batches(client, request)).count();
}

int run(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "client_calls HOST:PORT SCENE_ID POINTS\n");
    return 2;
  }
  const auto client = value(client::Client::connect({.target = argv[1]}));
  const std::vector<Double3> points = make_receivers(std::atoi(argv[3]));
  for (std::string line; std::getline(std::cin, line);) {
    const double before = processor_s();
    const auto start = std::chrono::steady_clock::now();
    const double check = call(client, argv[2], line, points);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    fmt::print("{} {} {}\n", wall.count(), processor_s() - before, check);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    return lucerna::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "client_calls: {}\n", error.what());
    return 1;
  }
}
