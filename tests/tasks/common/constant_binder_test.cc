#include "tasks/common/constant_binder.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <utility>

#include "core/base/error.h"

namespace engram {
namespace {

using tasks::ColorList, tasks::ConstantBinder, tasks::NameList, tasks::SampledRange,
    tasks::StepRange;

constexpr std::array kShapes = {"circle", "square", "triangle"};

ConstantList ids_of(const NameList& shapes) {
  ConstantList ids;
  for (int i = 0; i < shapes.size(); ++i) ids.emplace_back(shapes[i]);
  return ids;
}

// Parameters of a task, one constant of every kind.
struct Params {
  int COUNT = 3;
  double RADIUS = 0.1;
  std::array<double, 2> SIZE{0.1, 0.2};
  int shape = 0;
  NameList SHAPES{2};
  StepRange CUE_STEPS{1, 5};
  SampledRange<double> SPEED{0.5, 1};
  ColorList PALETTE{2};
  double BUTTON = 0.03;

  void declare(ConstantBinder& constants) {
    constants.integer("COUNT", COUNT, {1, 9}, "", "cubes");
    constants.real("RADIUS", RADIUS, {0.05, 0.5}, "m", "of the goal").published = false;
    constants.reals("SIZE", SIZE, {0.01, 1}, "m", "of the box");
    constants.name("SHAPE", shape, kShapes, "of the box");
    constants.names("SHAPES", SHAPES, kShapes, 1, "that are drawn", ids_of);
    constants.steps("CUE_STEPS", CUE_STEPS, {1, 100}, "how long", {"cue_steps", "length"});
    constants.range("SPEED", SPEED, {0.1, 2}, "m/s", "how fast", {"speed", "of the ball"});
    constants.colors("PALETTE", PALETTE, 1, "of the cubes");
    constants.fixed({{"HEIGHT", 1000}, {"COLORS", ConstantTable{{"0", ConstantList{0.5, 1}}}}});
    constants.fixed([&] { constants.real("BUTTON", BUTTON, {0.01, 0.1}, "m", "of the button"); });
  }
};

struct Declared {
  Params params;
  std::vector<TaskConstant> constants;

  const TaskConstant& at(std::string_view name) const {
    return *std::ranges::find(constants, name, &TaskConstant::name);
  }
};

Declared declare(const ConstantTable& chosen) {
  Declared declared;
  ConstantBinder binder(chosen);
  declared.params.declare(binder);
  declared.constants = binder.take();
  return declared;
}

std::string refusal(const ConstantTable& chosen) {
  try {
    declare(chosen);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("One line declares a constant, its default and its random variable", "[constants]") {
  const Declared declared = declare({});
  CHECK(declared.constants.size() == 11);
  CHECK(declared.at("COUNT").value == Constant(3));
  CHECK(declared.at("COUNT").kind == TaskConstant::Kind::kInteger);
  CHECK(declared.at("SHAPE").value == Constant("circle"));
  CHECK(declared.at("SHAPES").value == Constant(ConstantList{"circle", "square"}));
  CHECK(declared.at("SHAPES").published_value == Constant(ConstantList{0, 1}));
  CHECK(declared.at("CUE_STEPS").unit == "control steps");
  const StepRange& cue = declared.params.CUE_STEPS;
  CHECK(std::string(cue.variable.name) == "cue_steps");
  CHECK(std::string(cue.constant) == "CUE_STEPS");
  CHECK(declared.at("PALETTE").kind == TaskConstant::Kind::kColors);
  CHECK(declared.at("PALETTE").value == Constant(ConstantList{"red", "green"}));
  CHECK(std::ranges::none_of(declared.constants, &TaskConstant::changed));
}

TEST_CASE("Chosen values are set, and flagged", "[constants]") {
  const Declared declared = declare({{"COUNT", 7.0},
                                     {"SIZE", ConstantList{0.3, 0.4}},
                                     {"SHAPE", "square"},
                                     {"SHAPES", ConstantList{"triangle", "circle"}},
                                     {"CUE_STEPS", 4},
                                     {"SPEED", ConstantList{0.25, 2}}});
  const Params& params = declared.params;
  CHECK(params.COUNT == 7);
  CHECK(declared.at("COUNT").value == Constant(7));
  CHECK(params.SIZE == std::array{0.3, 0.4});
  CHECK(params.shape == 1);
  CHECK(params.SHAPES[0] == 2);
  CHECK(declared.at("SHAPES").published_value == Constant(ConstantList{2, 0}));
  CHECK(params.CUE_STEPS == StepRange{4, 4});
  CHECK(params.SPEED == SampledRange<double>{0.25, 2});
  CHECK(declared.at("COUNT").changed);
  CHECK_FALSE(declared.at("RADIUS").changed);
  CHECK(changed_constants(declared.constants).size() == 6);
}

TEST_CASE("Fixed constants are published, and can be given as they are", "[constants]") {
  const Declared declared = declare({{"HEIGHT", 1000.0}, {"BUTTON", 0.03F}});
  for (const char* name : {"HEIGHT", "BUTTON"}) {
    CHECK(declared.at(name).published);
    CHECK_FALSE(declared.at(name).changeable());
    CHECK_FALSE(declared.at(name).changed);
  }
  CHECK(refusal({{"COLORS", ConstantTable{{"0", ConstantList{0.5, 1.0}}}}}).empty());
  CHECK(refusal({{"HEIGHT", 1}}) ==
        "constant 'HEIGHT': 1 given, 1000 allowed: nobody can change it. This task has: COUNT, "
        "RADIUS, SIZE, SHAPE, SHAPES, CUE_STEPS, SPEED, PALETTE");
  CHECK(refusal({{"COLORS", ConstantTable{{"0", 7}}}})
            .starts_with("constant 'COLORS': {0: 7} given, {0: [0.5, 1]} allowed"));
  CHECK(refusal({{"HEIHGT", 1}}).starts_with("no constant named 'HEIHGT' to change; did you mean"));
}

TEST_CASE("Chosen values that are the task's own change nothing", "[constants]") {
  ConstantTable own;
  for (const TaskConstant& constant : declare({}).constants) {
    own.emplace_back(constant.name, constant.published_form());
  }
  const Declared declared = declare(own);
  CHECK(std::ranges::none_of(declared.constants, &TaskConstant::changed));
  CHECK(declared.at("COUNT").chosen);
  CHECK_FALSE(declared.at("HEIGHT").chosen);
}

TEST_CASE("Names are given by number, too, and as tables", "[constants]") {
  const auto shapes = [](const Constant& given) {
    return declare({{"SHAPES", given}}).at("SHAPES").value;
  };
  const Constant wanted = ConstantList{"triangle", "circle"};
  CHECK(shapes(ConstantList{2, 0}) == wanted);
  CHECK(shapes(ConstantList{2, "circle"}) == wanted);
  CHECK(shapes(ConstantTable{{"1", "circle"}, {"0", "triangle"}}) == wanted);
  CHECK(shapes("square") == Constant(ConstantList{"square"}));
  CHECK(refusal({{"SHAPES", ConstantList{3}}}).starts_with("constant 'SHAPES': [3] given"));
  CHECK(refusal({{"SHAPES", ConstantTable{{"1", "circle"}}}})
            .starts_with("constant 'SHAPES': {1: 'circle'} given"));
}

// A list of one list. Braces within braces would be a copy for some compilers.
Constant list_of(ConstantList item) { return ConstantList(1, Constant(std::move(item))); }

TEST_CASE("Colours are given by name and by red, green and blue", "[constants]") {
  const auto palette = [](const Constant& given) {
    return declare({{"PALETTE", given}}).at("PALETTE").value;
  };
  CHECK(palette("Teal") == Constant(ConstantList{"teal"}));
  CHECK(palette(ConstantList{"Lime", "yellow"}) == Constant(ConstantList{"green", "yellow"}));
  CHECK(palette(ConstantTable{{"0", ConstantList{0, 0, 1, 1}},
                              {"1", ConstantList{1, 128 / 255.0F, 0}},
                              {"2", ConstantList{0.2, 0.3, 0.4}}}) ==
        Constant(ConstantList{"blue", "olive", ConstantList{0.2, 0.3, 0.4}}));
  const Declared grey = declare({{"PALETTE", list_of({0.5, 0.5, 0.5, 1})}});
  CHECK(grey.params.PALETTE.size() == 1);
  CHECK(grey.params.PALETTE[0] == mjcf::Rgba{0.5, 0.5, 0.5, 1});
  CHECK(grey.at("PALETTE").published_value ==
        Constant(ConstantTable{{"0", ConstantList{0.5, 0.5, 0.5, 1.0}}}));
  for (const Constant& wrong :
       {Constant("pink"), Constant(ConstantList{"red", ConstantList{1, 0, 0, 1}}),
        list_of({255, 0, 0}), Constant(ConstantList{0.1, 0.2, 0.3}), list_of({1, 0, 0, 0.5}),
        list_of({1, 0})}) {
    INFO(in_words(wrong));
    CHECK(refusal({{"PALETTE", wrong}})
              .ends_with("1 to 16 different colours, of red, green, blue, yellow, magenta, cyan, "
                         "maroon, olive, teal or [red, green, blue] from 0 to 1, allowed"));
  }
}

TEST_CASE("Refusals name what was given and what is allowed", "[constants]") {
  CHECK(refusal({{"COUNT", 2.5}}) ==
        "constant 'COUNT': 2.5 given, a whole number from 1 to 9 allowed");
  CHECK(refusal({{"RADIUS", "wide"}}) ==
        "constant 'RADIUS': 'wide' given, a number from 0.05 to 0.5 allowed");
  CHECK(refusal({{"SIZE", ConstantList{0.1}}}) ==
        "constant 'SIZE': [0.1] given, 2 numbers from 0.01 to 1 allowed");
  CHECK(refusal({{"SHAPE", "star"}}) ==
        "constant 'SHAPE': 'star' given, one of circle, square, triangle allowed");
  CHECK(refusal({{"SHAPES", ConstantList{"circle", "circle"}}}) ==
        "constant 'SHAPES': ['circle', 'circle'] given, 1 to 3 different names of circle, square, "
        "triangle allowed");
  CHECK(refusal({{"CUE_STEPS", ConstantList{5, 2}}}) ==
        "constant 'CUE_STEPS': [5, 2] given, least and greatest, whole numbers from 1 to 100, "
        "allowed");
  CHECK(refusal({{"COUNT", 1}, {"COUNT", 2}}) == "constant 'COUNT' given twice, once allowed");
}

}  // namespace
}  // namespace engram
