// The words of an episode: what an observer who has seen all of it would say. For
// labels of data sets; privileged.
#pragma once

#include <string>
#include <vector>

namespace engram {

// Tells of the present state of an environment. A quantity that the episode hides is named from the
// step on in which it has been shown, and not before.
class Annotator {
 public:
  virtual ~Annotator() = default;

  // The subtasks of the episode, in order.
  virtual std::vector<std::string> plan(int env) const = 0;
  // The one that is to be done now: an index into the plan. It falls back when what it was based on
  // is undone.
  virtual int subtask(int env) const = 0;
  // Number of subtasks that are done. Where their order is free, this is not their index.
  virtual int subtasks_done(int env) const { return subtask(env); }
  // What has been shown and has to be remembered; empty if there is nothing.
  virtual std::string memory(int env) const = 0;
  // The prop that the subtask is about, -1: none.
  virtual int object(int env) const = 0;
};

}  // namespace engram
