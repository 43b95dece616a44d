// Tables of numbers with named columns.  The bytes of NPY files equal those of numpy 1.24.
#include "client/files/number_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/temp_directory.h"

namespace lucerna::client {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

class NumberTableTest : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = (directory_.path() / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  absl::StatusOr<NumberTable> read(const std::string& name, const std::string& bytes) const {
    return NumberTable::read(write(name, bytes), expected_);
  }
  /// The message without the folder of the file.
  std::string refusal(const std::string& name, const std::string& bytes) const {
    const auto table = read(name, bytes);
    EXPECT_EQ(table.status().code(), absl::StatusCode::kInvalidArgument) << table.status();
    return std::string(table.status().message()).substr(directory_.path().string().size() + 1);
  }

  const TempDirectory directory_;
  NumberTable::Expected expected_ = {
      {"x", "pdf", "light"}, "light", [](std::string_view word) -> absl::StatusOr<double> {
        if (word == "lamp") return 7;
        return absl::NotFoundError("no such lamp");
      }};
};

/// The output of numpy.save().
std::string npy(const std::string& dictionary, const std::string& numbers) {
  std::string text = dictionary + std::string(117 - dictionary.size(), ' ') + "\n";
  return std::string("\x93NUMPY\x01\x00v\x00", 10) + text + numbers;
}

template <class T>
std::string bytes(std::initializer_list<T> numbers) {
  std::string all;
  for (const T n : numbers) all.append(reinterpret_cast<const char*>(&n), sizeof(T));
  return all;
}

TEST_F(NumberTableTest, CsvColumnsHaveNames) {
  const auto table = read("a.csv", "# made by hand\npdf, x\n\n0.5,1\n , 2\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->rows(), 2U);
  EXPECT_EQ(table->column("x"), 1);
  EXPECT_EQ(table->column("light"), -1);
  EXPECT_EQ(table->at(0, 0), 0.5);
  EXPECT_TRUE(std::isnan(table->at(1, 0)));
  EXPECT_EQ(table->at(1, 1), 2);
  EXPECT_EQ(fs::path(table->place(1, 1)).filename().string(), "a.csv:5:4");
}

TEST_F(NumberTableTest, ColumnsWithoutNamesHaveTheirOrder) {
  const auto table = read("a.csv", "1,0.5,lamp\n2,0.25,3\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(table->names(), ElementsAre("x", "pdf", "light"));
  EXPECT_EQ(table->at(0, 2), 7);
  EXPECT_EQ(table->at(1, 2), 3);
  // The last columns may be left out.
  EXPECT_THAT(read("b.csv", "1,0.5\n")->names(), ElementsAre("x", "pdf"));
}

TEST_F(NumberTableTest, WrongCsvFilesAreRefusedWithTheirPlace) {
  EXPECT_EQ(refusal("a.csv", "x,pdf\n1,a\n"), "a.csv:2:3: pdf = \"a\" is not a number");
  EXPECT_EQ(refusal("a.csv", "x,pdf\n1, nan\n"), "a.csv:2:4: pdf = \"nan\" is not a number");
  EXPECT_EQ(refusal("a.csv", "x,light\n1,lmp\n"), "a.csv:2:3: light = \"lmp\": no such lamp");
  // The place of an empty field is that after its comma.
  EXPECT_EQ(fs::path(read("c.csv", "x,pdf,light\n1,,3\n2,0.5,\n")->place(0, 1)).filename().string(),
            "c.csv:2:3");
  EXPECT_EQ(fs::path(read("c.csv", "x,pdf,light\n1,,3\n2,0.5,\n")->place(1, 2)).filename().string(),
            "c.csv:3:7");
  EXPECT_EQ(refusal("a.csv", "x,pdf\n1\n"), "a.csv:2: 1 columns, allowed: 2, as before");
  EXPECT_EQ(refusal("a.csv", "1,2,3,4\n"),
            "a.csv:1: 4 columns without names, allowed: at most 3, in this order: x,pdf,light");
  EXPECT_EQ(refusal("a.csv", "x,x\n1,2\n"), "a.csv:1: column \"x\" is there twice, allowed: once");
  EXPECT_EQ(refusal("a.csv", "x,pdf\n"), "a.csv: has no rows");
  EXPECT_EQ(refusal("a.txt", "1"), "a.txt: unknown file type, must be .csv or .npy");
  const auto missing = NumberTable::read((directory_.path() / "b.csv").string(), expected_);
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(NumberTableTest, NpyArraysMayHaveNames) {
  const auto named =
      read("a.npy", npy("{'descr': [('pdf', '<f8'), ('light', '<i4')], 'fortran_order': False, "
                        "'shape': (2,), }",
                        bytes<double>({0.5}) + bytes<std::int32_t>({3}) + bytes<double>({0.25}) +
                            bytes<std::int32_t>({4})));
  ASSERT_TRUE(named.ok()) << named.status();
  EXPECT_THAT(named->names(), ElementsAre("pdf", "light"));
  EXPECT_EQ(named->at(1, 0), 0.25);
  EXPECT_EQ(named->at(1, 1), 4);
  EXPECT_EQ(fs::path(named->place(1, 1)).filename().string(), "a.npy: row 2, column light");
  const auto plain =
      read("b.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2), }",
                        bytes<float>({1, 2, 3, 4})));
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_THAT(plain->names(), ElementsAre("x", "pdf"));
  EXPECT_EQ(plain->at(1, 0), 3);
}

TEST_F(NumberTableTest, WrongNpyFilesAreRefused) {
  const std::string numbers = bytes<float>({1, 2, 3, 4});
  const auto header = [](const std::string& descr, const std::string& shape, bool fortran = false) {
    return "{'descr': " + descr + ", 'fortran_order': " + (fortran ? "True" : "False") +
           ", 'shape': " + shape + ", }";
  };
  EXPECT_EQ(refusal("a.npy", npy(header("'<f4'", "(4,)"), numbers)),
            "a.npy: shape = (4), allowed: (n, columns)");
  EXPECT_EQ(refusal("a.npy", npy(header("'<f4'", "(2, 3)"), numbers)),
            "a.npy: holds 16 bytes of numbers, its shape has 2 rows of 12");
  EXPECT_EQ(refusal("a.npy", npy(header("'<c8'", "(1, 2)"), numbers)),
            "a.npy: descr = <c8, allowed: <f4, <f8, <i4, <i8, <u4, <u8, |i1, |u1 or |b1");
  EXPECT_EQ(refusal("a.npy", npy(header("'<f4'", "(2, 2)", true), numbers)),
            "a.npy: fortran_order = True, allowed: False (numpy.ascontiguousarray makes it so)");
  EXPECT_EQ(refusal("a.npy", npy(header("[('x', '<f4', (2,))]", "(2,)"), numbers)),
            "a.npy: descr = [('x', '<f4', (2,))], allowed: one number per name");
  EXPECT_EQ(refusal("a.npy", npy(header("[('x', '<f4')]", "(2, 2)"), numbers)),
            "a.npy: shape = (2, 2), allowed for an array with names: (n,)");
  EXPECT_EQ(refusal("a.npy", npy(header("[('x', '<f4'), ('x', '<f4')]", "(2,)"), numbers)),
            "a.npy: column \"x\" is there twice, allowed: once");
  EXPECT_EQ(refusal("a.npy", npy(header("[('x', '<f4')]", "(4611686018427387908,)"), numbers)),
            "a.npy: holds 16 bytes of numbers, its shape has 4611686018427387908 rows of 4");
  EXPECT_EQ(refusal("a.npy", "x,y\n"), "a.npy: is not an NPY file");
}

}  // namespace
}  // namespace lucerna::client
