// Episodes of the oracle as their annotators tell them, frame by frame.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"

namespace engram::test {

using Texts = std::vector<std::string>;

// What is said of one frame.
struct AnnotatedFrame {
  std::vector<std::string> plan;
  int subtask = 0;
  int done = 0;
  std::string memory;
  int object = -1;

  const std::string& words() const { return plan[static_cast<std::size_t>(subtask)]; }
  friend bool operator==(const AnnotatedFrame&, const AnnotatedFrame&) = default;
};

inline AnnotatedFrame annotate(const Batch& batch, int index = 0) {
  const Annotator& annotator = *Queries(batch).annotator();
  return {annotator.plan(index), annotator.subtask(index), annotator.subtasks_done(index),
          annotator.memory(index), annotator.object(index)};
}

struct AnnotatedEpisode {
  std::vector<AnnotatedFrame> frames;  // frame t is shown before action t
  AnnotatedFrame end;                  // after the last action
  bool success = false;
  int cue_end = 0;
  std::unique_ptr<Batch> batch;  // as it is at the end

  // The different subtasks in words, in the order in which each came first.
  std::vector<std::string> subtasks() const {
    std::vector<std::string> all;
    for (const AnnotatedFrame& frame : frames) {
      if (std::find(all.begin(), all.end(), frame.words()) == all.end())
        all.push_back(frame.words());
    }
    return all;
  }
  // The different memories, likewise.
  std::vector<std::string> memories() const {
    std::vector<std::string> all;
    for (const AnnotatedFrame& frame : frames) {
      if (all.empty() || all.back() != frame.memory) all.push_back(frame.memory);
    }
    return all;
  }
};

// Plays one to its end, or to its first success.
inline AnnotatedEpisode play_annotated(std::string_view id, std::uint64_t seed,
                                       std::vector<Pin> pins = {}) {
  AnnotatedEpisode episode;
  episode.batch = make_env(id, {.seed = seed,
                                .threads = 1,
                                .obs_mode = ObsMode::kNone,
                                .auto_reset = AutoReset::kOff,
                                .terminate_on_success = true,
                                .pins = std::move(pins)});
  episode.batch->reset();
  episode.cue_end = Queries(*episode.batch).cue_end(0);
  while ((episode.batch->outputs().terminated[0] | episode.batch->outputs().truncated[0]) == 0) {
    episode.frames.push_back(annotate(*episode.batch));
    step(*episode.batch, Policy::kOracle);
  }
  episode.end = annotate(*episode.batch);
  episode.success = episode.batch->outputs().success[0] != 0;
  return episode;
}

}  // namespace engram::test
