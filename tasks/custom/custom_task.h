// A custom task, with rules outside of the library: made from its description; its rules get the
// engine's columns.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/task/answer_controller.h"
#include "core/task/batch_task.h"
#include "tasks/common/family_base.h"
#include "tasks/custom/annotator.h"
#include "tasks/custom/array_exchange.h"
#include "tasks/custom/draws.h"
#include "tasks/custom/instance.h"

namespace engram::tasks {

class CustomTask final : public FamilyBase, public BatchTask, public AnswerController {
 public:
  // Throws Error (kInvalidArgument) if the description cannot work.
  CustomTask(const RegistryEntry& entry, std::unique_ptr<CustomInstance> instance);

  void bind(const Bindings& bindings) override;
  void reset(const Episode& episode) override { draws_.sample(episode); }
  int cue_end(int env) const override { return cue_end_[env]; }
  void sampled_values(int env, float* out) const override { draws_.write(env, out); }
  // {name} in the text stands for a draw's value.
  std::string instruction(int env) const override;
  BatchTask* batch_task() override { return this; }
  const Annotator* annotator() const override { return has_words() ? &annotator_ : nullptr; }

  ChoiceForm choice_form() const override;
  // Once the cue is over and actions count.
  bool is_choice_due(int env) const override;

  void reset(std::span<const int> envs) override;
  bool moves_before_physics() const override { return about_.moves_before_physics; }
  void before_physics(std::span<const int> envs) override;
  void advance(std::span<const int> envs) override;
  void evaluate(std::span<const int> envs) override;
  void observe(std::span<const int> envs, FloatRows out) override;
  void dense_reward(std::span<const int> envs, FloatRows out) override;
  void act(std::span<const int> envs, Script script, FloatRows actions) override;

  // Not called: there are batch_task.
  using Task::before_physics;
  void advance(Range envs) override;
  void evaluate(Range envs) override;
  void observe(Range envs, FloatRows out) override;
  void dense_reward(Range envs, FloatRows out) override;
  const Expert& expert() const override;

 private:
  bool has_choices() const { return !about_.choices.items.empty(); }
  void write_choice(int env) const;
  bool has_words() const { return !about_.words.subtasks.empty(); }
  void describe(const CustomDescription& about);
  void add_engine_columns();
  void add_own_columns();
  void settle_props(std::span<const int> envs) const;

  std::unique_ptr<CustomInstance> instance_;
  CustomDescription about_;
  CustomDraws draws_;
  CustomAnnotator annotator_;
  std::unique_ptr<ArrayExchange> arrays_;
  Column<std::int32_t> cue_end_;
  Column<std::uint8_t> moved_;  // (num_props) poses that the rules have set
  Column<float> reward_;
  Column<float> state_;    // all state fields
  Column<float> actions_;  // of scripts
  Column<std::uint64_t> policy_key_;
  Column<std::int32_t> choice_;  // (count) keys of the caller's answer, -1: none
};

}  // namespace engram::tasks
