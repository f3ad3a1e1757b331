#include "core/base/column.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace engram {
namespace {

TEST_CASE("A column has one row of its width for every environment", "[column]") {
  ColumnStore store(3);
  const Column<double> wide = store.add<double>("wide", 4, "m", "four numbers");
  const Column<std::uint8_t> flag = store.add<std::uint8_t>("flag");
  CHECK(wide.width() == 4);
  CHECK(wide.row(2) == wide.data() + 8);
  CHECK(&flag[1] == flag.data() + 1);
  CHECK(std::all_of(wide.data(), wide.data() + 12, [](double v) { return v == 0; }));
  CHECK(reinterpret_cast<std::uintptr_t>(wide.data()) % 64 == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(flag.data()) % 64 == 0);
  CHECK(store.size() == 2);
  CHECK(store.num_envs() == 3);
  CHECK(store.row_bytes() == 4 * sizeof(double) + 1);
}

TEST_CASE("Columns are found by name with their fields", "[column]") {
  ColumnStore store(2);
  const Column<float> first = store.add<float>("first", 2, "rad", "an angle");
  for (int i = 0; i < 20; ++i) store.add<std::int32_t>("more_" + std::to_string(i));
  const ColumnView view = store.find("first");
  REQUIRE(view.field != nullptr);
  CHECK(view.field->name == "first");
  CHECK(view.field->width == 2);
  CHECK(view.field->dtype == DType::kFloat32);
  CHECK(view.field->unit == "rad");
  CHECK(view.field->description == "an angle");
  CHECK(view.data == reinterpret_cast<std::byte*>(first.data()));
  CHECK(view.row(1) == reinterpret_cast<std::byte*>(first.row(1)));
  CHECK(store[0].field == view.field);
  CHECK(store.find("fir").field == nullptr);
}

TEST_CASE("A taken name or an empty width is refused", "[column]") {
  ColumnStore store(2);
  store.add<float>("a");
  CHECK_THROWS_WITH(store.add<double>("a"), Catch::Contains("'a' exists already"));
  CHECK_THROWS_WITH(store.add<double>("b", 0), Catch::Contains("width 0 given"));
  CHECK_THROWS_AS(store.add<double>("b", -1), Error);
  CHECK(store.size() == 1);
  CHECK(store.row_bytes() == 4);
}

TEST_CASE("Rows are saved, cleared and loaded one environment at a time", "[column]") {
  ColumnStore store(3);
  const Column<double> numbers = store.add<double>("numbers", 2);
  const Column<std::uint8_t> flag = store.add<std::uint8_t>("flag");
  for (int env = 0; env < 3; ++env) {
    numbers.row(env)[0] = env + 0.25;
    numbers.row(env)[1] = -env;
    flag[env] = static_cast<std::uint8_t>(env);
  }
  std::vector<std::byte> saved(store.row_bytes());
  store.save_row(1, saved);
  store.clear_row(1);
  CHECK(numbers.row(1)[0] == 0);
  CHECK(flag[1] == 0);
  CHECK(numbers.row(0)[0] == 0.25);
  CHECK(numbers.row(2)[0] == 2.25);
  CHECK(flag[2] == 2);

  store.load_row(2, saved);
  CHECK(numbers.row(2)[0] == 1.25);
  CHECK(numbers.row(2)[1] == -1);
  CHECK(flag[2] == 1);
  CHECK(numbers.row(0)[0] == 0.25);
}

TEST_CASE("A row is copied to a store of the same fields", "[column]") {
  ColumnStore from(2);
  const Column<float> values = from.add<float>("values", 2);
  from.add<std::int32_t>("count");
  ColumnStore to(2);
  to.add_like(from);
  CHECK(to.signature() == from.signature());
  values.row(1)[1] = 3;
  from.copy_row_to(to, 1);
  const auto* copied = reinterpret_cast<const float*>(to.find("values").data);
  CHECK(std::vector<float>(copied, copied + 4) == std::vector<float>{0, 0, 0, 3});
}

TEST_CASE("Stores of different fields have different signatures", "[column]") {
  const auto signature = [](const std::vector<Field>& fields) {
    ColumnStore store(1);
    for (const Field& field : fields) store.add(field);
    return store.signature();
  };
  const Field a{"a", 2, DType::kFloat32, "", ""};
  const Field b{"b", 1, DType::kInt32, "", ""};
  const std::uint64_t reference = signature({a, b});
  CHECK(signature({a, b}) == reference);
  CHECK(signature({b, a}) != reference);
  CHECK(signature({a}) != reference);
  CHECK(signature({{"c", 2, DType::kFloat32, "", ""}, b}) != reference);
  CHECK(signature({{"a", 3, DType::kFloat32, "", ""}, b}) != reference);
  CHECK(signature({{"a", 2, DType::kFloat64, "", ""}, b}) != reference);
  CHECK(signature({}) != reference);
}

TEST_CASE("Element types have sizes and the names that numpy gives them", "[column]") {
  CHECK(size_of(DType::kBool) == 1);
  CHECK(size_of(DType::kInt32) == 4);
  CHECK(size_of(DType::kUInt64) == 8);
  CHECK(size_of(DType::kFloat32) == 4);
  CHECK(size_of(DType::kFloat64) == 8);
  CHECK(std::string(dtype_name(DType::kBool)) == "bool");
  CHECK(std::string(dtype_name(DType::kInt32)) == "int32");
  CHECK(std::string(dtype_name(DType::kUInt64)) == "uint64");
  CHECK(std::string(dtype_name(DType::kFloat32)) == "float32");
  CHECK(std::string(dtype_name(DType::kFloat64)) == "float64");
}

}  // namespace
}  // namespace engram
