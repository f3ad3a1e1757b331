// Rows of observations in fixed scales, in which plain networks learn.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/object_tokens.h"

namespace engram::training {

// Rows of states: positions are vectors from the TCP, with a flag for what is there, and all that
// is left has the unit of its field.
class StateRows {
 public:
  // horizon: of control steps. Throws Error if the fields are not of a state.
  StateRows(std::span<const RangedField> fields, int horizon);

  int dim() const { return dim_; }
  void write(const float* row, float* out) const;

 private:
  enum class Kind : std::uint8_t { kJoints, kTcp, kPosition, kDifference, kPlain };
  struct Part {
    Kind kind = Kind::kPlain;
    int offset = 0;
    int width = 0;
    float unit = 1;
  };

  static Part part_of(const Field& field, float horizon);
  static float* write_part(const Part& part, const float* row, const float* tcp, float* out);
  void write_goal(const float* row, const float* tcp, float* out) const;

  std::vector<Part> parts_;
  std::vector<int> goals_;  // offsets of positions of which all but one are zero
  int goal_width_ = 0;
  int tcp_ = 0;  // offset
  int dim_ = 0;
};

// Rows of objects: tokens in an order that lasts until other objects come into view, by kind,
// shape, colour and from left to right, with vectors from the TCP.
class ObjectRows {
 public:
  // Throws Error if the fields are not of objects.
  ObjectRows(std::span<const RangedField> fields, int num_envs);

  int dim() const { return dim_; }
  // begins: the row is an episode's first.
  void write(int env, const float* row, bool begins, float* out);
  // Writes a row in the order of the one before, which stays.
  void write_last(int env, const float* row, float* out) const;

 private:
  void sort(int env, const float* tokens);

  int first_ = 0;  // elements before the tokens
  int qpos_ = 0;   // offsets
  int qvel_ = 0;
  int tcp_ = 0;
  int tokens_ = 0;
  int dim_ = 0;
  // (num_envs, tokens): the token at each place, and the looks of each token.
  std::vector<std::uint8_t> order_;
  std::vector<std::int32_t> looks_;
};

}  // namespace engram::training
