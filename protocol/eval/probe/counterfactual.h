// Pasts of an episode: hidden draws with different answers, and changes that leave the answer.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/math/random.h"
#include "protocol/eval/probe/question.h"
#include "tasks/registry.h"

namespace engram {

// The draw that pasts of a task differ in; empty: it hides nothing.
std::string_view hidden_draw(const MemoryFacts& facts, const TaskInfo& info);

// What a family's irrelevant change is of, in results.
std::string irrelevant_part(const MemoryFacts& facts, const TaskInfo& info);

class CounterfactualSampler {
 public:
  // random: of the choices of one episode number.
  CounterfactualSampler(Lookahead& lookahead, const MemoryFacts& facts, std::uint64_t seed);

  // Pins of the hidden draw.
  std::vector<Pin> any();
  // Pins of the hidden draw with another answer; or with this one, by another draw where there is
  // one. Nothing if none is found.
  std::optional<std::vector<Pin>> other_answer(const std::vector<Pin>& past);

  // Two pasts with one answer, which differ in what does not matter, and the step of their
  // question: in what the family names, or where that leaves nothing to change, in the arm's start
  // pose. Nothing if the task has no such past.
  struct IrrelevantChange {
    EpisodeDraw one;
    EpisodeDraw other;
    int question = 0;
    bool joins = false;  // at the question the other's scene is that of the one
  };
  std::optional<IrrelevantChange> irrelevant_change(const std::vector<Pin>& past);

 private:
  const RandomVariable* find(std::string_view name) const;
  std::vector<double> values_of(const RandomVariable& variable);
  std::vector<double> answer_of(const std::vector<Pin>& past);
  std::optional<IrrelevantChange> with_questions(std::vector<Pin> one, std::vector<Pin> other);
  std::optional<IrrelevantChange> own_change(const std::vector<Pin>& past);
  std::optional<IrrelevantChange> change_draw(const std::vector<Pin>& past);
  std::optional<IrrelevantChange> change_order(const std::vector<Pin>& past);
  std::optional<IrrelevantChange> change_values(const std::vector<Pin>& past);
  std::optional<IrrelevantChange> change_start(const std::vector<Pin>& past);

  Lookahead& lookahead_;
  const MemoryFacts& facts_;
  std::uint64_t seed_;
  RandomStream random_;
  const RandomVariable* hidden_;
};

}  // namespace engram
