// A question to a policy that names answers instead of acting, and what it names.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/task/answer_controller.h"
#include "protocol/parallel/work_item.h"

namespace engram {

// Frames are the observations since the episode's last question, or since it began, in order; the
// last one is of now.
struct ChoiceQuestion {
  std::string_view env_id;
  int slot = 0;                       // of the episode in the batch, below max_slots
  int episode = 0;                    // 0 to n_episodes - 1; for messages, not for policies
  std::int32_t number = 0;            // by which policies know the episode
  std::optional<std::uint64_t> seed;  // of the episode, if requests name it
  std::int32_t step = 0;              // control steps taken so far
  std::int32_t index = 0;             // of the question in the episode
  std::string instruction;
  ChoiceForm form;  // of the answer; its items are not those that are asked for
  std::vector<std::string> choices;
  std::span<const std::int32_t> steps;  // of the frames
  std::span<const float> proprio;       // (frames, proprio_dim)
  std::span<const std::uint8_t> rgb;    // (frames, height, width, 6); empty unless asked for
  std::span<const float> state;         // (frames, state_dim); empty unless asked for
  std::span<const std::string> texts;   // (frames) of the objects; empty unless asked for
  int height = 0;
  int width = 0;
  int state_dim = 0;
  int proprio_dim = 0;
  int max_slots = 0;
  std::uint64_t policy_seed = 0;
  const WorkContext* context = nullptr;  // a policy that waits must give up when it is stopped
};

// Takes the answer to a question. Setters throw Error, naming what is allowed, for an answer of
// another form.
class ChoiceAnswer {
 public:
  // The question outlives this object.
  explicit ChoiceAnswer(const ChoiceQuestion& question) : question_(question) {}

  // Indices of the question's choices, in the answer's order.
  void set(std::span<const int> indices);
  // Texts of choices, or their indices in digits.
  void set(std::span<const std::string> texts);

  // Throws Error if nothing was set.
  std::span<const int> indices() const;

 private:
  const ChoiceQuestion& question_;
  std::vector<int> indices_;
};

// Keys of `items` items in the order in which a question lists them: the number of the question in
// an episode of that task and seed.
std::vector<int> choice_order(const ChoiceForm& form, std::string_view id, std::uint64_t seed,
                              int number, std::size_t items);

}  // namespace engram
