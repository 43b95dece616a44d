// The examples of the documentation print the documented output.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/testing/local_server_test.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

// A point light of 10 cd at (1.2, -1.5, 3.2), seen from straight below, 3.2 m away: 10 / 3.2^2 =
// 0.9765625 lx.  Its flux is 4 pi 10 = 125.6637 lm.  The picture has 160 x 120 pixels.
constexpr char kExpected[] =
    "sample 0.976562 at 3.2 m\n"
    "power 125.664 lm\n"
    "visible 1\n"
    "tile 160 x 120\n";

class Examples : public testing::LocalServerTest {
 protected:
  testing::LocalServerOptions options() const override {
    return {.scene_root = test_data("reference")};
  }
};

TEST_F(Examples, CppSendsTheFourQueries) {
  const Outcome outcome =
      run_program({build_path("tests/e2e/example_ask"), server().target(), "point.pbrt"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, kExpected);
}

TEST_F(Examples, PythonSendsTheFourQueries) {
  const Outcome outcome = run_program(
      {LUCERNA_PYTHON, source_path("docs/examples/python/ask.py"), server().target(), "point.pbrt"},
      "", {{"PYTHONPATH", build_path("tests/e2e/stubs")}, {"PYTHONDONTWRITEBYTECODE", "1"}});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, kExpected);
}

}  // namespace
}  // namespace lucerna
