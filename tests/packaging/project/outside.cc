#include <engram/engram.h>

#include <iostream>

int main() {
  try {
    auto env = engram::make("RememberColor3-VLA-v0", {.num_envs = 16, .seed = 1});
    std::vector<float> actions = env.make_actions();
    env.reset();
    for (int i = 0; i < env.horizon(); ++i) {
      env.act(engram::Policy::kOracle, actions);
      env.step(actions);
    }
    int successes = 0;
    for (const std::uint8_t success : env.success_once()) successes += success;
    std::cout << "C++: engram " << engram::version() << ", " << successes << " of "
              << env.num_envs() << " succeed\n";
    return successes >= 15 ? 0 : 1;
  } catch (const engram::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
