#include "protocol/custom_tasks/task_documents.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "protocol/custom_tasks/keyed_table.h"
#include "protocol/custom_tasks/prop_documents.h"

namespace engram {
namespace {

using tasks::CustomColumn;
using tasks::CustomConstant;
using tasks::CustomDefinition;
using tasks::CustomDescription;
using tasks::CustomDraw;

constexpr int kMaxWidth = 100'000;
constexpr int kMaxNumber = 1 << 24;  // of whole numbers that rows can have

Json parsed(std::string_view json, const std::string& what) {
  std::optional<Json> document = parse_json(json);
  if (!document) throw Error(Error::kInvalidArgument, what + ": not JSON");
  return std::move(*document);
}

// Names that become names of columns and attributes.
std::string name_in(const KeyedTable& table) {
  std::string name = table.text("name");
  if (name.empty() || name.size() > 60) {
    table.refuse("'name': '" + name + "' given, 1 to 60 letters allowed");
  }
  return name;
}

// --- constants ---

CustomConstant constant_of(const Json& document, const std::string& what) {
  constexpr std::array kKinds = {"fixed", "integer", "real", "integer_range", "real_range", "name"};
  using Kind = TaskConstant::Kind;
  constexpr std::array kOfEach = {Kind::kFixed,        Kind::kInteger,   Kind::kReal,
                                  Kind::kIntegerRange, Kind::kRealRange, Kind::kName};
  const KeyedTable table(document, what + ", a constant");
  table.allow(std::array{"name", "kind", "value", "low", "high", "unit", "text", "names"});
  CustomConstant constant;
  constant.name = name_in(table);
  constant.kind = kOfEach[table.choice("kind", kKinds)];
  constant.value = table.value("value");
  if (constant.kind != Kind::kFixed && constant.kind != Kind::kName) {
    constant.low = table.number("low");
    constant.high = table.number("high");
  }
  constant.unit = table.text("unit", "");
  constant.text = table.text("text", "");
  constant.names = table.texts("names");
  return constant;
}

// --- draws ---

CustomDraw draw_of(const Json& document, const std::string& what) {
  using Kind = CustomDraw::Kind;
  constexpr std::array kKinds = {"integer", "real", "order", "choice", "places"};
  const KeyedTable unnamed(document, what + ", a draw");
  CustomDraw draw;
  draw.name = name_in(unnamed);
  const KeyedTable table(document, what + ", draw '" + draw.name + "'");
  draw.kind = static_cast<Kind>(table.choice("kind", kKinds));
  draw.unit = table.text("unit", draw.kind == Kind::kPlaces ? "m" : "");
  draw.text = table.text("text", "");
  draw.constant = table.text("constant", "");
  switch (draw.kind) {
    case Kind::kInteger:
      draw.low = table.integer("low", -kMaxNumber, kMaxNumber);
      draw.high = table.integer("high", -kMaxNumber, kMaxNumber);
      draw.width = table.has("width") ? table.integer("width", 1, kMaxWidth) : 1;
      break;
    case Kind::kReal:
      draw.low = table.number("low");
      draw.high = table.number("high");
      draw.width = table.has("width") ? table.integer("width", 1, kMaxWidth) : 1;
      break;
    case Kind::kOrder:
      draw.width = table.integer("count", 1, kMaxWidth);
      draw.high = draw.width - 1;
      break;
    case Kind::kChoice:
      draw.high = table.integer("of", 1, kMaxWidth) - 1;
      draw.width = table.integer("count", 1, static_cast<int>(draw.high) + 1);
      break;
    case Kind::kPlaces:
      draw.width = 2 * table.integer("count", 1, 1000);
      draw.area_low = table.numbers<2>("low");
      draw.area_high = table.numbers<2>("high");
      draw.min_distance = table.number("least_distance", 0);
      draw.low = std::min(draw.area_low[0], draw.area_low[1]);
      draw.high = std::max(draw.area_high[0], draw.area_high[1]);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        if (draw.area_low[axis] > draw.area_high[axis]) table.refuse("'low' is above 'high'");
      }
      break;
  }
  if (draw.low > draw.high) table.refuse("'low' is above 'high'");
  draw.names = table.texts("names");
  if (!draw.names.empty() &&
      (draw.is_real() || static_cast<double>(draw.names.size()) != draw.high - draw.low + 1)) {
    table.refuse("'names': " + std::to_string(draw.names.size()) +
                 " given, one for each whole number from 'low' to 'high' needed");
  }
  return draw;
}

// --- columns ---

DType dtype_in(const KeyedTable& table) {
  constexpr std::array kNames = {"bool", "int32", "float32", "float64", "uint64"};
  constexpr std::array kTypes = {DType::kBool, DType::kInt32, DType::kFloat32, DType::kFloat64,
                                 DType::kUInt64};
  return kTypes[table.choice("dtype", kNames)];
}

CustomColumn column_of(const Json& document, const std::string& what) {
  const KeyedTable table(document, what);
  table.allow(std::array{"name", "dtype", "width", "unit", "text", "low", "high", "privileged"});
  CustomColumn column;
  column.field.name = name_in(table);
  column.field.dtype = dtype_in(table);
  column.field.width = table.has("width") ? table.integer("width", 1, kMaxWidth) : 1;
  column.field.unit = table.text("unit", "");
  column.field.description = table.text("text", "");
  column.field.privileged = table.truth("privileged", false);
  if (table.has("low") || table.has("high")) {
    column.limits = {table.integer("low", -kMaxNumber, kMaxNumber),
                     table.integer("high", -kMaxNumber, kMaxNumber)};
  }
  return column;
}

Field state_field_of(const Json& document, const std::string& what) {
  const KeyedTable table(document, what);
  table.allow(std::array{"name", "width", "unit", "text"});
  return {name_in(table), table.has("width") ? table.integer("width", 1, kMaxWidth) : 1,
          DType::kFloat32, table.text("unit", ""), table.text("text", "")};
}

// --- the whole ---

template <class T>
std::vector<T> all_of(const KeyedTable& table, const char* key, const std::string& what,
                      T (*of)(const Json&, const std::string&)) {
  std::vector<T> values;
  for (const Json& one : table.list(key)) values.push_back(of(one, what));
  return values;
}

void read_phases(const KeyedTable& table, CustomDescription& about) {
  for (const Json& phase : table.list("phases")) {
    const Json one = JsonTable{{"phase", phase}};
    const std::vector<std::string> texts = KeyedTable(one, table.what()).texts("phase");
    if (texts.size() != 2) table.refuse("'phases' has to be a list of [name, condition]");
    about.phases.emplace_back(texts[0], texts[1]);
  }
}

void read_methods(const KeyedTable& table, CustomDescription& about) {
  for (const std::string& method : table.texts("methods")) {
    if (method == "before_physics") {
      about.moves_before_physics = true;
    } else if (method == "oracle") {
      about.has_oracle = true;
    } else if (method == "blind") {
      about.has_blind = true;
    } else if (method == "sweep") {
      about.has_sweep = true;
    } else {
      table.refuse("'methods' has '" + method +
                   "', allowed are: before_physics, oracle, blind, sweep");
    }
  }
}

void read_words(const KeyedTable& table, CustomDescription& about) {
  if (!table.has("words")) return;
  const KeyedTable words(table.value("words"), table.what() + ", 'words'");
  words.allow(std::array{"subtasks", "memory", "unknown"});
  about.words.subtasks = words.texts("subtasks");
  if (about.words.subtasks.empty()) words.refuse("'subtasks' has to be a list of at least one");
  about.words.memory = words.text("memory", "");
  about.words.unknown = words.text("unknown", about.words.unknown);
}

void read_choices(const KeyedTable& table, CustomDescription& about) {
  if (!table.has("choices")) return;
  const KeyedTable choices(table.value("choices"), table.what() + ", 'choices'");
  choices.allow(std::array{"question", "items", "count"});
  about.choices.question = choices.text("question");
  about.choices.items = choices.texts("items");
  const auto items = static_cast<int>(about.choices.items.size());
  if (items < 2) choices.refuse("'items' has to be a list of at least two");
  for (const std::string& item : about.choices.items) {
    if (std::ranges::count(about.choices.items, item) == 1) continue;
    choices.refuse("'items': '" + item + "' given twice, once allowed");
  }
  if (choices.has("count")) about.choices.count = choices.integer("count", 1, items);
  if (!about.has_blind) table.refuse("'choices' given without the method blind, one needed");
}

// Draws that are the range of a constant.
void check_constants(const KeyedTable& table, const CustomDescription& about) {
  for (const CustomDraw& draw : about.draws) {
    const bool ranged =
        draw.kind == CustomDraw::Kind::kInteger || draw.kind == CustomDraw::Kind::kReal;
    if (!draw.constant.empty() && !ranged) {
      table.refuse("draw '" + draw.name + "': 'constant' given, for integer and real draws only");
    }
  }
}

}  // namespace

CustomDefinition parse_definition(std::string_view json) {
  const std::string what = "definition of a task";
  const Json document = parsed(json, what);
  const KeyedTable table(document, what);
  table.allow(std::array{"id", "family", "horizon", "instruction", "memory_type", "oracle_floor",
                         "constants", "source"});
  CustomDefinition definition;
  definition.id = table.text("id");
  definition.family = table.text("family");
  definition.horizon = table.integer("horizon", 1, 1'000'000);
  definition.instruction = table.text("instruction");
  definition.memory_type = table.text("memory_type", "");
  definition.oracle_floor = table.number("oracle_floor", definition.oracle_floor);
  definition.constants = all_of(table, "constants", what, constant_of);
  (void)table.text("source", "");  // it counts as a part of the content
  definition.content = to_hex(sha256(to_line(document)));
  return definition;
}

CustomDescription parse_task_description(std::string_view json, std::string_view task) {
  constexpr std::array kTerminations = {"never", "success", "success_or_failed"};
  const std::string what = "task '" + std::string(task) + "'";
  const Json document = parsed(json, what);
  const KeyedTable table(document, what);
  table.allow(std::array{"candidates", "guess_rate", "answer", "answer_rate", "termination",
                         "frozen_cue", "success_reward", "oracle_dim", "hidden", "phases",
                         "table_ends", "props", "draws", "memory", "infos", "state_fields",
                         "methods", "words", "choices"});
  CustomDescription about;
  about.candidates = table.has("candidates") ? table.integer("candidates", 1, kMaxNumber) : 1;
  about.guess_rate = table.number("guess_rate", 0);
  about.answer = table.text("answer", "");
  about.answer_rate = table.number("answer_rate", 0);
  if (table.has("termination")) {
    about.termination = static_cast<Termination>(table.choice("termination", kTerminations));
  }
  about.frozen_cue = table.truth("frozen_cue", false);
  about.success_reward = table.number("success_reward", 1);
  if (about.success_reward <= 0) table.refuse("'success_reward' has to be above 0");
  about.oracle_dim = table.has("oracle_dim") ? table.integer("oracle_dim", 0, kMaxWidth) : 0;
  about.hidden = table.text("hidden", "");
  about.table_ends = table.truth("table_ends", false);
  about.props = all_of(table, "props", what, to_prop);
  about.draws = all_of(table, "draws", what, draw_of);
  about.memory = all_of(table, "memory", what + ", a memory column", column_of);
  about.infos = all_of(table, "infos", what + ", an info", column_of);
  about.state_fields = all_of(table, "state_fields", what + ", a state field", state_field_of);
  read_phases(table, about);
  read_methods(table, about);
  read_words(table, about);
  read_choices(table, about);
  check_constants(table, about);
  return about;
}

}  // namespace engram
