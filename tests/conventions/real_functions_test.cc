// What the C library and Eigen compute with sines and the like differs between processors. What
// environments show and remember is computed with core/math/real_functions.h.
#include <catch2/catch.hpp>
#include <regex>
#include <string>

#include "tests/conventions/sources.h"

namespace engram {
namespace {

bool is_inexact(const std::string& line) {
  static const std::regex inexact(
      R"(\bstd::(a?(sin|cos|tan)h?|atan2|exp2?|expm1|log(2|10|1p)?|pow|hypot|cbrt|erfc?)\()"
      R"(|\b(AngleAxis|Rotation2D)|\.(angularDistance|slerp|eulerAngles)\()"
      R"(|\bmju_(axisAngle2Quat|quat2Vel|quatIntegrate|euler2Quat)\()");
  return std::regex_search(line, inexact);
}

// Eigen adds floats in an order that depends on the processor: core/math/float_sums.h has lengths.
bool has_floats_of_eigen(const std::string& line) {
  static const std::regex floats(R"(\b(Row)?(Vector|Matrix|Array)[0-9X]+f\b)");
  return std::regex_search(line, floats);
}

// OpenGL's images depend on the driver anyway.
bool may_be_inexact(const std::filesystem::path& file) {
  return file.parent_path() == "render/egl";
}

TEST_CASE("Nothing inexact is computed with what the C library and Eigen have", "[conventions]") {
  for (const char* folder : {"core", "mjcf", "tasks", "render"}) {
    for (const auto& file : test::files_in(folder, {".h", ".cc"})) {
      if (may_be_inexact(file)) continue;
      for (const std::string& line : test::lines_of(test::kRoot / file)) {
        if (is_inexact(line)) FAIL_CHECK(file.string() << ": " << line);
      }
    }
  }
}

TEST_CASE("Eigen adds up no floats of states, actions and rewards", "[conventions]") {
  for (const char* folder : {"core", "tasks"}) {
    for (const auto& file : test::files_in(folder, {".h", ".cc"})) {
      for (const std::string& line : test::lines_of(test::kRoot / file)) {
        if (has_floats_of_eigen(line)) FAIL_CHECK(file.string() << ": " << line);
      }
    }
  }
  CHECK(has_floats_of_eigen("using Vector = Eigen::Map<const Eigen::VectorXf>;"));
  CHECK(has_floats_of_eigen("Eigen::Map<Eigen::Vector3f> translation(action);"));
  CHECK_FALSE(has_floats_of_eigen("Eigen::Vector3d offset;"));
}

TEST_CASE("Inexact functions are found", "[conventions]") {
  for (const char* line :
       {"x = std::sin(y);", "1 - std::tanh(5 * d)", "std::atan2(a, b)", "std::hypot(x, y)",
        "std::exp(-x)", "Eigen::AngleAxisd(a, axis)", "q.angularDistance(p)", "std::log1p(x)",
        "mju_quatIntegrate(q, v, h);"}) {
    INFO(line);
    CHECK(is_inexact(line));
  }
  for (const char* line : {"real::sin(y)", "std::sqrt(x)", "std::expected(x)", "std::floor(x)",
                           "std::logic_error(\"\")", "std::cout"}) {
    INFO(line);
    CHECK_FALSE(is_inexact(line));
  }
}

}  // namespace
}  // namespace engram
