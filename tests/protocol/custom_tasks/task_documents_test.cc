#include "protocol/custom_tasks/task_documents.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "protocol/custom_tasks/prop_documents.h"

namespace engram {
namespace {

using Catch::Contains;

tasks::CustomDescription described(const std::string& inside) {
  return parse_task_description("{" + inside + "}", "LampOrder-v0");
}

mjcf::Prop prop(const std::string& json) {
  return to_prop(parse_json(json).value(), "task 'LampOrder-v0'");
}

TEST_CASE("A definition is read", "[own_tasks]") {
  const tasks::CustomDefinition definition = parse_definition(
      R"({"id": "LampOrder-v0", "family": "LampOrder", "horizon": 60, "instruction": "Wait.",
          "memory_type": "Sequence", "oracle_floor": 0.9,
          "constants": [{"name": "LAMPS", "kind": "integer", "value": 3, "low": 1, "high": 9},
                        {"name": "CUE", "kind": "integer_range", "value": [1, 5], "low": 1,
                         "high": 50, "unit": "control steps"},
                        {"name": "MODE", "kind": "name", "value": "a", "names": ["a", "b"]}]})");
  CHECK(definition.id == "LampOrder-v0");
  CHECK(definition.horizon == 60);
  CHECK(definition.oracle_floor == 0.9);
  REQUIRE(definition.constants.size() == 3);
  CHECK(definition.constants[0].kind == TaskConstant::Kind::kInteger);
  CHECK(definition.constants[1].kind == TaskConstant::Kind::kIntegerRange);
  CHECK(definition.constants[1].high == 50);
  CHECK(definition.constants[2].names == std::vector<std::string>{"a", "b"});
}

TEST_CASE("Mistakes in a definition are named", "[own_tasks][errors]") {
  CHECK_THROWS_WITH(parse_definition("{"), "definition of a task: not JSON");
  CHECK_THROWS_WITH(parse_definition("[]"), Contains("a table of names and values needed"));
  CHECK_THROWS_WITH(parse_definition(R"({"id": "A-v0", "horizen": 3})"),
                    Contains("it has 'horizen'; did you mean 'horizon'?"));
  CHECK_THROWS_WITH(parse_definition(R"({"id": "A-v0", "family": "A", "instruction": ""})"),
                    Contains("'horizon' is missing"));
  CHECK_THROWS_WITH(
      parse_definition(R"({"id": "A-v0", "family": "A", "instruction": "", "horizon": 0})"),
      Contains("'horizon': 0 given, a whole number from 1 to 1000000 allowed"));
  CHECK_THROWS_WITH(
      parse_definition(R"({"id": 3, "family": "A", "instruction": "", "horizon": 9})"),
      Contains("'id' has to be a text"));
}

TEST_CASE("Words and names of draws are read", "[own_tasks]") {
  const tasks::CustomDescription about = described(
      R"("draws": [{"name": "target", "kind": "integer", "low": 1, "high": 2, "names": ["a", "b"]}],
         "words": {"subtasks": ["wait", "touch {target}"], "memory": "{target}"})");
  CHECK(about.draws[0].names == std::vector<std::string>{"a", "b"});
  CHECK(about.words.subtasks.size() == 2);
  CHECK(about.words.memory == "{target}");
  CHECK(about.words.unknown == "right");
  CHECK_THROWS_WITH(described(R"("words": {"subtasks": []})"), Contains("at least one"));
  CHECK_THROWS_WITH(
      described(R"("draws": [{"name": "x", "kind": "order", "count": 3, "names": ["a"]}])"),
      Contains("'names': 1 given, one for each whole number"));
}

TEST_CASE("A list of answers is read", "[own_tasks]") {
  const std::string question =
      R"("methods": ["blind"], "choices": {"question": "Which?", "items": )";
  const tasks::CustomDescription about = described(question + R"(["a", "b", "c"], "count": 2})");
  CHECK(about.choices.question == "Which?");
  CHECK(about.choices.items.size() == 3);
  CHECK(about.choices.count == 2);
  CHECK(described("").choices.items.empty());
  CHECK_THROWS_WITH(described(question + R"(["a"]})"), Contains("a list of at least two"));
  CHECK_THROWS_WITH(described(question + R"(["a", "a"]})"), Contains("'a' given twice"));
  CHECK_THROWS_WITH(described(question + R"(["a", "b"], "count": 3})"), Contains("'count'"));
  CHECK_THROWS_WITH(described(R"("choices": {"question": "Which?", "items": ["a", "b"]})"),
                    Contains("without the method blind"));
}

TEST_CASE("A mesh is read, with its hull and the body of a solid", "[own_tasks]") {
  const std::string corners = "[[0,0,0],[0.1,0,0],[0,0.1,0],[0,0,0.1],[0.02,0.02,0.02]]";
  const mjcf::Prop found =
      prop(R"({"kind": "mesh", "name": "m", "density": 600, "vertices": )" + corners + "}");
  REQUIRE(found.geoms.size() == 1);
  CHECK(found.geoms[0].corners.size() == 4);
  CHECK(found.mass == Approx(600 * 0.001 / 6));
  CHECK(found.pos[2] == Approx(0).margin(1e-12));
  const mjcf::Prop parts =
      prop(R"({"kind": "parts", "name": "m", "geoms": [{"type": "mesh", "vertices": )" + corners +
           "}]}");
  CHECK(parts.mass == Approx(1000 * 0.001 / 6));
  const auto refused = [&](const std::string& vertices) {
    return R"({"kind": "mesh", "name": "m", "vertices": )" + vertices + "}";
  };
  CHECK_THROWS_WITH(prop(refused("[[0,0,0]]")), Contains("1 given, 4 to 20000 allowed"));
  CHECK_THROWS_WITH(prop(refused("[[0,0],[1,0,0],[0,1,0],[0,0,1]]")), Contains("[x, y, z]"));
  CHECK_THROWS_WITH(prop(refused("[[0,0,0],[3,0,0],[0,1,0],[0,0,1]]")), Contains("-2 to 2 m"));
  CHECK_THROWS_WITH(prop(refused("[[0,0,0],[1,0,0],[0,1,0],[1,1,0]]")), Contains("flat"));
}

TEST_CASE("Facts, columns and methods of a description are read", "[own_tasks]") {
  const tasks::CustomDescription about = described(
      R"("candidates": 3, "termination": "success", "frozen_cue": true, "success_reward": 3,
         "answer": "the cube", "hidden": "target", "phases": [["cue", "elapsed < 3"]],
         "memory": [{"name": "count", "dtype": "int32", "low": 0, "high": 4}],
         "infos": [{"name": "away", "dtype": "float32", "unit": "m", "privileged": true}],
         "state_fields": [{"name": "goal", "width": 3, "unit": "m"}],
         "methods": ["before_physics", "oracle"])");
  CHECK(about.candidates == 3);
  CHECK(about.termination == Termination::kSuccess);
  CHECK(about.frozen_cue);
  CHECK(about.phases.at(0).second == "elapsed < 3");
  CHECK(about.memory.at(0).limits == std::pair(0, 4));
  CHECK(about.infos.at(0).field.privileged);
  CHECK(about.state_fields.at(0).width == 3);
  CHECK(about.moves_before_physics);
  CHECK(about.has_oracle);
  CHECK_FALSE(about.has_sweep);
}

TEST_CASE("Draws of all kinds are read", "[own_tasks]") {
  using Kind = tasks::CustomDraw::Kind;
  const tasks::CustomDescription about = described(
      R"("draws": [{"name": "a", "kind": "integer", "low": 2, "high": 5, "constant": "RANGE"},
                   {"name": "b", "kind": "real", "low": -1, "high": 1, "width": 4},
                   {"name": "c", "kind": "order", "count": 5},
                   {"name": "d", "kind": "choice", "of": 9, "count": 2},
                   {"name": "e", "kind": "places", "count": 3, "low": [-0.1, -0.2],
                    "high": [0.1, 0.2], "least_distance": 0.05}])");
  REQUIRE(about.draws.size() == 5);
  CHECK(about.draws[0].constant == "RANGE");
  CHECK(about.draws[1].width == 4);
  CHECK(about.draws[2].high == 4);
  CHECK((about.draws[3].width == 2 && about.draws[3].high == 8));
  CHECK(about.draws[4].kind == Kind::kPlaces);
  CHECK((about.draws[4].width == 6 && about.draws[4].low == -0.2));
}

TEST_CASE("Mistakes in a description are named", "[own_tasks][errors]") {
  CHECK_THROWS_WITH(described(R"("termination": "sometimes")"),
                    Contains("allowed are: never, success, success_or_failed"));
  CHECK_THROWS_WITH(described(R"("success_reward": 0)"), Contains("has to be above 0"));
  CHECK_THROWS_WITH(described(R"("methods": ["dance"])"), Contains("'methods' has 'dance'"));
  CHECK_THROWS_WITH(described(R"("draws": [{"name": "a", "kind": "dice"}])"),
                    Contains("draw 'a'") && Contains("integer, real, order, choice, places"));
  CHECK_THROWS_WITH(described(R"("draws": [{"name": "a", "kind": "real", "low": 2, "high": 1}])"),
                    Contains("'low' is above 'high'"));
  CHECK_THROWS_WITH(described(R"("draws": [{"name": "a", "kind": "choice", "of": 3, "count": 4}])"),
                    Contains("'count': 4 given, a whole number from 1 to 3 allowed"));
  CHECK_THROWS_WITH(described(R"("memory": [{"name": "a", "dtype": "text"}])"),
                    Contains("bool, int32, float32, float64, uint64"));
}

TEST_CASE("Props of all kinds are read", "[own_tasks]") {
  for (const char* json :
       {R"({"kind": "cube", "name": "a", "half_size": 0.02, "color": [1, 0, 0]})",
        R"({"kind": "box", "name": "a", "half_size": [0.1, 0.02, 0.03], "density": 300})",
        R"({"kind": "sphere", "name": "a", "radius": 0.02, "body": "visual"})",
        R"({"kind": "cylinder", "name": "a", "radius": 0.02, "half_height": 0.03})",
        R"({"kind": "ball", "name": "a", "radius": 0.02})",
        R"({"kind": "shape", "name": "a", "shape": "cross"})",
        R"({"kind": "target_disc", "name": "a", "radius": 0.05})",
        R"({"kind": "disc", "name": "a", "radius": 0.05, "half_height": 0.005})",
        R"({"kind": "mug", "name": "a"})",
        R"({"kind": "peg", "name": "a", "half_length": 0.1, "half_width": 0.02,
            "colors": [[1, 0, 0], [0, 0, 1, 1]]})",
        R"({"kind": "battery", "name": "a"})",
        R"({"kind": "battery_tray", "name": "a", "slots": [[0, 0], [0.03, 0]]})",
        R"({"kind": "battery_socket", "name": "a"})", R"({"kind": "button_base", "name": "a"})",
        R"({"kind": "button_cap", "name": "a", "travel": 0.01})",
        R"({"kind": "lamp_body", "name": "a"})", R"({"kind": "lamp_bulb", "name": "a"})",
        R"({"kind": "parts", "name": "a", "body": "kinematic", "object": "place",
            "geoms": [{"type": "box", "size": [0.1, 0.1, 0.01]},
                      {"type": "capsule", "size": [0.01, 0.05, 0], "pos": [0, 0, 0.1]}]})"}) {
    CAPTURE(json);
    const mjcf::Prop made = prop(json);
    CHECK(made.name == "a");
    CHECK_FALSE(made.geoms.empty());
  }
}

TEST_CASE("A prop has the body that its description asks for", "[own_tasks]") {
  const mjcf::Prop dynamic = prop(
      R"({"kind": "box", "name": "a", "half_size": [0.1, 0.1, 0.1], "density": 500,
          "friction": 0.7})");
  CHECK(dynamic.body_type == mjcf::BodyType::kDynamic);
  CHECK(dynamic.mass == Approx(4));
  CHECK(dynamic.friction == 0.7);
  const mjcf::Prop visual =
      prop(R"({"kind": "box", "name": "a", "half_size": [0.1, 0.1, 0.1], "body": "visual"})");
  CHECK(visual.body_type == mjcf::BodyType::kKinematic);
  CHECK_FALSE(visual.geoms.at(0).collides);
}

TEST_CASE("Mistakes in props are named", "[own_tasks][errors]") {
  CHECK_THROWS_WITH(prop(R"({"kind": "cube", "half_size": 0.02})"), Contains("'name' is missing"));
  CHECK_THROWS_WITH(prop(R"({"kind": "cone", "name": "a"})"),
                    Contains("prop 'a'") && Contains("'cone' given, allowed are: cube, box"));
  CHECK_THROWS_WITH(prop(R"({"kind": "cube", "name": "a b", "half_size": 0.02})"),
                    Contains("letters, digits and _ allowed"));
  CHECK_THROWS_WITH(prop(R"({"kind": "cube", "name": "a", "half_size": 0})"),
                    Contains("'half_size' has to be a length of 0 to 2 m"));
  CHECK_THROWS_WITH(prop(R"({"kind": "cube", "name": "a", "half_size": 0.1, "color": [2, 0, 0]})"),
                    Contains("numbers from 0 to 1"));
  CHECK_THROWS_WITH(prop(R"({"kind": "ball", "name": "a", "radius": 0.1, "mass": 2})"),
                    Contains("it has 'mass'"));
  CHECK_THROWS_WITH(
      prop(R"({"kind": "parts", "name": "a", "geoms": [{"type": "capsule", "size": [1, 1, 0]}]})"),
      Contains("capsules and ellipsoids are for kinematic and visual props only"));
}

}  // namespace
}  // namespace engram
