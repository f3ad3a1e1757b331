// Random variables of a custom task: declared from its description,
// sampled into columns.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/column.h"
#include "core/task/episode.h"
#include "tasks/custom/description.h"

namespace engram::tasks {

class CustomDraws {
 public:
  // Throws Error (kInvalidArgument) for places that do not fit into their area.
  explicit CustomDraws(std::vector<CustomDraw> draws);

  std::span<const CustomDraw> list() const { return draws_; }
  std::vector<RandomVariable> variables() const;
  // All values, in order, as a batch shows them to privileged users.
  std::vector<Field> fields() const;

  // Adds the columns, "draw:" before the name.
  void bind(ColumnStore& memory);
  // Samples an episode. Throws Error (kTaskFailed) if places do not fit, which the constructor
  // has tried before.
  void sample(const Episode& episode) const;
  // Writes all values of an environment.
  void write(int env, float* out) const;
  // A text in which {name} stands for a draw's value: its name if it has names, else its first
  // number. instead_of(name): a text, or nothing for the value.
  using Instead = std::function<std::optional<std::string>(const std::string& name)>;
  std::string filled(std::string text, int env, const Instead& instead_of = {}) const;

 private:
  // Nothing if there is no draw of that name.
  std::optional<std::string> text_of(std::string_view name, int env) const;

  std::vector<CustomDraw> draws_;
  std::vector<Column<std::int32_t>> integers_;  // one of the two is used for each
  std::vector<Column<double>> reals_;
};

// Name of the column of a draw.
std::string draw_column(const std::string& name);

}  // namespace engram::tasks
