// The words of episodes of a custom task: texts of its description, and
// columns that its rules write.
#pragma once

#include <string>
#include <vector>

#include "core/base/column.h"
#include "core/task/annotator.h"
#include "tasks/custom/description.h"
#include "tasks/custom/draws.h"

namespace engram::tasks {

class CustomAnnotator final : public Annotator {
 public:
  // Both must outlive this object.
  CustomAnnotator(const CustomDescription& about, const CustomDraws& draws)
      : about_(about), draws_(draws) {}

  // Adds the columns subtask, shown and meant.
  void bind(ColumnStore& memory, Column<std::uint8_t> success);

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  int subtasks_done(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override { return meant_[env]; }

 private:
  std::string filled(const std::string& text, int env) const;

  const CustomDescription& about_;
  const CustomDraws& draws_;
  Column<std::int32_t> subtask_;
  Column<std::uint8_t> shown_;
  Column<std::int32_t> meant_;
  Column<std::uint8_t> success_;
};

}  // namespace engram::tasks
