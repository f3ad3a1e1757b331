#include "tasks/shell_game/annotator.h"

#include <array>

#include "core/base/index.h"
#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

constexpr double kOverMug = 0.15;    // m from its origin: the tool is about to touch it
constexpr double kBehindMug = 0.15;  // m likewise: or to push it
constexpr double kAtHandle = 0.09;   // m likewise: or to grasp it

constexpr std::array<const char*, kCups> kBalls = {"red", "green", "blue"};

std::string place(int slot) { return kSlotNames[at(slot)]; }

// "on the left", "in the middle"
std::string in_place(int slot) { return (slot == 1 ? "in the " : "on the ") + place(slot); }

}  // namespace

int ShellGameAnnotator::mug(int env) const {
  const int target = view_.game.target(env);
  return view_.lamp != nullptr ? view_.lamp->mug_of(env, target) : target;
}

bool ShellGameAnnotator::is_cue(int env) const {
  return view_.game.state().elapsed[env] < view_.game.cue_end(env);
}

int ShellGameAnnotator::final_slot(int env, int mug) const {
  return view_.shuffle != nullptr ? view_.shuffle->final_slot(env, mug) : mug;
}

// --- the plan ---

// The lamp names its colour, and a shuffle is over, when the manipulation phase begins.
std::string ShellGameAnnotator::cup_words(int env) const {
  const bool known =
      view_.game.is_manipulation(env) || (view_.lamp == nullptr && view_.shuffle == nullptr);
  if (known) return "the " + place(final_slot(env, mug(env))) + " cup";
  return view_.lamp != nullptr ? "the cup with the lamp's color" : "the cup with the ball";
}

std::vector<std::string> ShellGameAnnotator::skill_subtasks(const std::string& cup) const {
  switch (view_.skill) {
    case Skill::kTouch:
      return {"move to " + cup, "touch " + cup};
    case Skill::kPush:
      return {"move behind " + cup, "push " + cup + " forward"};
    case Skill::kPick:
      break;
  }
  return {"move to the handle of " + cup, "grasp " + cup + " by its handle", "lift " + cup};
}

std::vector<std::string> ShellGameAnnotator::plan(int env) const {
  std::vector<std::string> plan;
  plan.emplace_back(view_.lamp != nullptr ? "remember which color is under each cup"
                                          : "remember where the ball is");
  if (view_.shuffle != nullptr) plan.emplace_back("follow the cups as they are shuffled");
  for (std::string& skill : skill_subtasks(cup_words(env))) plan.push_back(std::move(skill));
  return plan;
}

int ShellGameAnnotator::skill_subtasks_done(int env) const {
  const State& state = view_.game.state();
  const Eigen::Vector3d pos = view_.game.mugs().pos(env, mug(env));
  switch (view_.skill) {
    case Skill::kTouch:
      return tool_is_at(state, env, pos, kOverMug) ? 1 : 0;
    case Skill::kPush:
      return tool_is_at(state, env, pos, kBehindMug) ? 1 : 0;
    case Skill::kPick:
      break;
  }
  if (is_grasping(state, env, mug(env))) return 2;
  return tool_is_at(state, env, pos, kAtHandle) ? 1 : 0;
}

int ShellGameAnnotator::subtask(int env) const {
  if (is_cue(env)) return 0;
  if (!view_.game.is_manipulation(env)) return 1;
  return (view_.shuffle != nullptr ? 2 : 1) + skill_subtasks_done(env);
}

// --- memory ---

// Balls show from the first image on.
std::string ShellGameAnnotator::balls(int env, bool at_the_end) const {
  const auto slot = [&](int mug) { return at_the_end ? final_slot(env, mug) : mug; };
  if (view_.lamp == nullptr) {
    return at_the_end ? "is under the " + place(slot(mug(env))) + " cup now"
                      : "the ball was " + in_place(slot(mug(env)));
  }
  std::vector<std::string> items;
  items.reserve(kCups);
  for (int color = 0; color < kCups; ++color) {
    items.push_back(std::string("the ") + kBalls[at(color)] + " ball " +
                    (at_the_end ? "is" : "was") + " " +
                    in_place(slot(view_.lamp->mug_of(env, color))));
  }
  return enumerate(items);
}

std::string ShellGameAnnotator::memory(int env) const {
  const bool shuffled = view_.shuffle != nullptr && view_.game.is_manipulation(env);
  if (!shuffled) return balls(env, /*at_the_end=*/false);
  const char* link = view_.lamp != nullptr ? "; now " : " and ";
  return balls(env, false) + link + balls(env, true);
}

// --- the object ---

// In the cue of a lamp game all balls count.
int ShellGameAnnotator::object(int env) const {
  if (is_cue(env)) return view_.ball;
  const bool known = view_.lamp == nullptr || view_.game.is_manipulation(env);
  return known ? mug(env) : -1;
}

}  // namespace engram::tasks
