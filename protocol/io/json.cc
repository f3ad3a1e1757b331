#include "protocol/io/json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/error.h"

namespace engram {
namespace {

using LibraryJson = nlohmann::json;

constexpr std::size_t kDeepest = 64;  // levels of tables and lists

// The value under the key of a table, which may be const; null if there is none.
template <class Table>
auto* value_of(Table& table, std::string_view key) {
  const auto found = std::find_if(table.begin(), table.end(),
                                  [key](const auto& entry) { return entry.first == key; });
  return found == table.end() ? nullptr : &found->second;
}

// --- reading ---

// Takes a text from the JSON library's parser, piece by piece.
class Builder final : public nlohmann::json_sax<LibraryJson> {
 public:
  Json take() { return std::move(root_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(std::int64_t value) override { return add(value); }
  bool number_unsigned(std::uint64_t value) override { return add(value); }
  bool number_float(double value, const std::string& /*text*/) override { return add(value); }
  bool string(std::string& value) override { return add(std::move(value)); }
  bool binary(LibraryJson::binary_t& /*value*/) override { return false; }

  bool start_object(std::size_t /*size*/) override { return open(JsonTable()); }
  bool start_array(std::size_t /*size*/) override { return open(JsonList()); }
  bool key(std::string& name) override {
    open_.back().key = std::move(name);
    return true;
  }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t /*at*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;
  }

 private:
  struct Level {
    Json document;    // a list or a table
    std::string key;  // of the next value
  };

  bool open(Json document) {
    if (open_.size() == kDeepest) return false;
    open_.push_back({std::move(document), {}});
    return true;
  }
  bool close() {
    Json closed = std::move(open_.back().document);
    open_.pop_back();
    return add(std::move(closed));
  }
  bool add(Json value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return true;
    }
    Level& level = open_.back();
    if (auto* list = std::get_if<JsonList>(&level.document.value)) {
      list->push_back(std::move(value));
      return true;
    }
    auto& table = std::get<JsonTable>(level.document.value);
    if (Json* same = value_of(table, level.key)) {
      *same = std::move(value);  // the last one counts
    } else {
      table.emplace_back(std::move(level.key), std::move(value));
    }
    return true;
  }

  std::vector<Level> open_;
  Json root_;
};

// --- writing ---

std::string scalar_text(const LibraryJson& value) {
  return value.dump(-1, ' ', false, LibraryJson::error_handler_t::replace);
}

// The text of a value that nests no other.
struct ScalarText {
  std::string operator()(std::nullptr_t /*nothing*/) const { return "null"; }
  std::string operator()(double number) const {
    return std::isfinite(number) ? scalar_text(number) : "null";
  }
  template <class T>
  std::string operator()(const T& value) const {
    return scalar_text(value);
  }
  std::string operator()(const JsonList& /*nests*/) const { return {}; }
  std::string operator()(const JsonTable& /*nests*/) const { return {}; }
};

struct JsonStyle {
  bool lines = true;
  int depth = 0;

  JsonStyle deeper() const { return {lines, depth + 1}; }
  void begin_line(std::string& text) const {
    constexpr int kIndentation = 2;
    if (!lines) return;
    text += '\n';
    text.append(static_cast<std::size_t>(kIndentation * depth), ' ');
  }
};

void append(const Json& document, const JsonStyle& layout, std::string& text) {
  const auto* items = std::get_if<JsonList>(&document.value);
  const auto* entries = std::get_if<JsonTable>(&document.value);
  if (items == nullptr && entries == nullptr) {
    text += std::visit(ScalarText(), document.value);
    return;
  }
  const std::size_t size = items != nullptr ? items->size() : entries->size();
  text += items != nullptr ? '[' : '{';
  for (std::size_t i = 0; i < size; ++i) {
    if (i > 0) text += ',';
    layout.deeper().begin_line(text);
    if (entries != nullptr) {
      text += scalar_text((*entries)[i].first);
      text += layout.lines ? ": " : ":";
    }
    append(items != nullptr ? (*items)[i] : (*entries)[i].second, layout.deeper(), text);
  }
  if (size > 0) layout.begin_line(text);
  text += items != nullptr ? ']' : '}';
}

// --- content ---

[[noreturn]] void refuse(const Json& document, const std::string& needed) {
  throw Error(Error::kIo, to_line(document) + " given, " + needed + " needed");
}

template <class T>
const T& content(const Json& document, const char* needed) {
  const T* found = std::get_if<T>(&document.value);
  if (found == nullptr) refuse(document, needed);
  return *found;
}

}  // namespace

std::optional<Json> parse_json(std::string_view text) {
  Builder builder;
  if (!LibraryJson::sax_parse(text, &builder)) return std::nullopt;
  return builder.take();
}

std::string to_text(const Json& document) {
  std::string text;
  append(document, {}, text);
  return text + "\n";
}

std::string to_line(const Json& document) {
  std::string text;
  append(document, {.lines = false}, text);
  return text;
}

const Json* find(const Json& document, std::string_view key) {
  const auto* table = std::get_if<JsonTable>(&document.value);
  return table == nullptr ? nullptr : value_of(*table, key);
}

const Json& part(const Json& document, std::string_view key) {
  const Json* found = find(document, key);
  if (found == nullptr) throw Error(Error::kIo, "no '" + std::string(key) + "'");
  return *found;
}

bool is_null(const Json& document) { return document == Json(); }

bool is_table(const Json& document) { return std::holds_alternative<JsonTable>(document.value); }

bool is_number(const Json& document) {
  return std::holds_alternative<double>(document.value) ||
         std::holds_alternative<std::int64_t>(document.value) ||
         std::holds_alternative<std::uint64_t>(document.value);
}

bool truth(const Json& document) { return content<bool>(document, "a truth"); }

double number(const Json& document) {
  if (const auto* whole = std::get_if<std::int64_t>(&document.value)) {
    return static_cast<double>(*whole);
  }
  if (const auto* whole = std::get_if<std::uint64_t>(&document.value)) {
    return static_cast<double>(*whole);
  }
  return content<double>(document, "a number");
}

std::uint64_t whole_number(const Json& document, std::uint64_t most) {
  const auto* small = std::get_if<std::int64_t>(&document.value);
  const auto* large = std::get_if<std::uint64_t>(&document.value);
  if (small != nullptr && *small >= 0 && static_cast<std::uint64_t>(*small) <= most) {
    return static_cast<std::uint64_t>(*small);
  }
  if (large != nullptr && *large <= most) return *large;
  refuse(document, "a whole number up to " + std::to_string(most));
}

const std::string& text(const Json& document) { return content<std::string>(document, "a text"); }

const JsonList& list(const Json& document) { return content<JsonList>(document, "a list"); }

const JsonTable& table(const Json& document) { return content<JsonTable>(document, "a table"); }

}  // namespace engram
