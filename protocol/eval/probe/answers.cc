#include "protocol/eval/probe/answers.h"

#include <algorithm>
#include <string>

namespace engram {
namespace {

// Digits of an answer in order, zeros included.
std::string sorted_digits(std::int32_t answer) {
  std::string digits = std::to_string(answer);
  std::ranges::sort(digits);
  return digits;
}

}  // namespace

bool same_answer(const TrialResult& one, const TrialResult& other, bool any_order) {
  if (one.answered == 0 || other.answered == 0) return false;
  if (any_order) return sorted_digits(one.answer) == sorted_digits(other.answer);
  return one.answer == other.answer;
}

bool answers_as(const TrialResult& in_other_scene, const TrialResult& in_own_scene, AnswerCut cut) {
  if (same_answer(in_other_scene, in_own_scene, false)) return true;
  if (in_other_scene.answered == 0 || in_own_scene.answered == 0) return false;
  if (in_other_scene.correct != 0) return false;  // then the scene has not cut it
  switch (cut) {
    case AnswerCut::kNone:
      return false;
    case AnswerCut::kDigits:
      return std::to_string(in_own_scene.answer).starts_with(std::to_string(in_other_scene.answer));
    case AnswerCut::kCount:
      return in_other_scene.answer < in_own_scene.answer;
  }
  return false;
}

}  // namespace engram
