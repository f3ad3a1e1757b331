#include "tasks/gather_and_recall/annotator.h"

#include <algorithm>

#include "core/base/index.h"
#include "tasks/common/poses.h"
#include "tasks/common/words.h"

namespace engram::tasks {

std::string GatherAnnotator::color_name(int env) const {
  return name_color(FLASH_COLORS[at(view_.flash_color[env])]);
}

std::vector<std::string> GatherAnnotator::plan(int env) const {
  const int cubes = view_.params.N_CUBES;
  std::vector<std::string> plan;
  for (int cube = 1; cube <= cubes; ++cube) {
    plan.push_back(cubes == 1 ? "move the cube onto the disc"
                              : "move a cube onto the disc, cube " + std::to_string(cube) + " of " +
                                    std::to_string(cubes));
  }
  plan.push_back(view_.flash_triggered[env] != 0 ? "press the " + color_name(env) + " button"
                                                 : "press the button with the flash's color");
  return plan;
}

// The last cube is not done before all of them rest on the disc.
int GatherAnnotator::subtask(int env) const {
  const int cubes = view_.params.N_CUBES;
  if (view_.all_on_disc[env] != 0) return cubes;
  return std::min(view_.n_on_disc[env], cubes - 1);
}

std::string GatherAnnotator::memory(int env) const {
  if (view_.flash_triggered[env] == 0) return {};
  return "the lamp flashed " + color_name(env);
}

// The cube to move: among those that have not been on the disc, the one in the hand, or the first
// one, which the oracle takes; the nearest of all where they only have to come to rest.
int GatherAnnotator::cube_to_move(int env) const {
  const State& state = *view_.engine.state;
  int first = -1;
  int nearest = 0;
  const auto distance = [&](int cube) {
    return (prop_pos(state, env, cube) - tcp_pos(state, env)).norm();
  };
  for (int cube = 0; cube < view_.params.N_CUBES; ++cube) {
    if (distance(cube) < distance(nearest)) nearest = cube;
    if (view_.on_disc.row(env)[cube] != 0) continue;
    if (is_grasping(state, env, cube)) return cube;
    if (first < 0) first = cube;
  }
  return first >= 0 ? first : nearest;
}

int GatherAnnotator::object(int env) const {
  if (view_.all_on_disc[env] == 0) return cube_to_move(env);
  if (view_.flash_triggered[env] == 0) return -1;
  return view_.buttons[at(view_.flash_color[env])].cap();
}

}  // namespace engram::tasks
