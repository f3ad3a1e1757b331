// Learns to touch the remembered cube by cross-entropy search, with nothing but Eigen and the
// installed header: the policy is a linear map from what is observed to how the hand moves.
//
//   cross_entropy [GENERATIONS [SEED]]
//
// Each generation draws candidates around the mean of the search, tries all of them side by side in
// one batch (every candidate on the same episodes), and moves mean and spread to those of the best.
// The first candidate is the mean itself, whose score the table shows.
#include <engram/engram.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>

namespace {

using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr const char* kId = "RememberColor3-VLA-v0";
constexpr int kCandidates = 48;
constexpr int kEpisodes = 8;  // of each candidate and generation
constexpr int kElites = 10;
constexpr int kTrials = 256;  // episodes of the comparison at the end

// Columns of the state that the policy reads (`engram info` lists them).
constexpr int kTcpOffset = 18;
constexpr int kGoalOffset = 26;  // of three cubes; zeros but for the one to touch
constexpr int kGoals = 3;
constexpr int kFeatures = 3 + 3 * kGoals + 1;  // and a constant
constexpr int kActions = 4;                    // translation of the hand, gripper
constexpr float kPerMetre = 10;                // brings positions to the size of actions

// A candidate: (kFeatures, kActions).
using Weights = Eigen::MatrixXf;

// Inputs of the policy, one row per environment.
RowMatrix features(const engram::VectorEnv& env) {
  const Eigen::Map<const RowMatrix> state(env.observation().data(), env.num_envs(),
                                          env.state_dim());
  RowMatrix out(env.num_envs(), kFeatures);
  out.leftCols<3>() = kPerMetre * state.middleCols<3>(kTcpOffset);
  out.middleCols<3 * kGoals>(3) = kPerMetre * state.middleCols<3 * kGoals>(kGoalOffset);
  out.col(kFeatures - 1).setOnes();
  return out;
}

struct Score {
  double episode_return = 0;
  double success = 0;  // rate of success at any time in the episode
};

// Runs one episode of every environment, the candidates taking turns of equal length.
std::vector<Score> run(engram::VectorEnv& env, const std::vector<Weights>& candidates,
                       std::uint64_t first_seed) {
  const int share = env.num_envs() / static_cast<int>(candidates.size());
  std::vector<std::uint64_t> seeds(static_cast<std::size_t>(env.num_envs()));
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    seeds[i] = first_seed + i % static_cast<std::size_t>(share);
  }
  env.reset({.seeds = seeds});
  RowMatrix actions(env.num_envs(), kActions);
  for (int step = 0; step < env.horizon(); ++step) {
    const RowMatrix seen = features(env);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const int row = static_cast<int>(i) * share;
      actions.middleRows(row, share).noalias() = seen.middleRows(row, share) * candidates[i];
    }
    actions = actions.array().tanh();
    env.step({actions.data(), static_cast<std::size_t>(actions.size())});
  }

  std::vector<Score> scores(candidates.size());
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    Score& score = scores[i / static_cast<std::size_t>(share)];
    score.episode_return += env.episode_return()[i] / share;
    score.success += static_cast<double>(env.success_once()[i]) / share;
  }
  return scores;
}

// The search: a normal distribution over weights, each on its own.
struct Search {
  Weights mean = Weights::Zero(kFeatures, kActions);
  Weights spread = Weights::Constant(kFeatures, kActions, 0.3F);
  std::mt19937_64 random;

  explicit Search(std::uint64_t seed) : random(seed) {}

  std::vector<Weights> candidates() {
    std::normal_distribution<float> normal;
    std::vector<Weights> drawn(kCandidates, mean);
    for (std::size_t i = 1; i < drawn.size(); ++i) {
      drawn[i] += spread.cwiseProduct(
          Weights::NullaryExpr(kFeatures, kActions, [&] { return normal(random); }));
    }
    return drawn;
  }

  // Moves to the best candidates. `floor` keeps the spread from collapsing early.
  void update(const std::vector<Weights>& drawn, const std::vector<Score>& scores, float floor) {
    std::vector<std::size_t> order(drawn.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&scores](std::size_t a, std::size_t b) {
      return scores[a].episode_return > scores[b].episode_return;
    });
    Weights sum = Weights::Zero(kFeatures, kActions);
    Weights squares = Weights::Zero(kFeatures, kActions);
    for (int i = 0; i < kElites; ++i) {
      const Weights& elite = drawn[order[static_cast<std::size_t>(i)]];
      sum += elite;
      squares += elite.cwiseAbs2();
    }
    mean = sum / kElites;
    const Weights variance = (squares / kElites - mean.cwiseAbs2()).cwiseMax(0.0F);
    spread = variance.cwiseSqrt().array() + floor;
  }
};

void learn(Search& search, int generations) {
  engram::VectorEnv env = engram::make(kId, {.num_envs = kCandidates * kEpisodes,
                                             .control_mode = engram::ControlMode::kPdEeDeltaPos,
                                             .auto_reset = engram::AutoReset::kOff});
  std::printf("generation   return of mean   of best   success of mean   spread   seconds\n");
  const auto start = std::chrono::steady_clock::now();
  for (int generation = 0; generation < generations; ++generation) {
    const std::vector<Weights> drawn = search.candidates();
    const std::vector<Score> scores =
        run(env, drawn, static_cast<std::uint64_t>(generation) * kEpisodes);
    const float floor = 0.1F * std::max(0.0F, 1.0F - 2.0F * static_cast<float>(generation) /
                                                         static_cast<float>(generations));
    search.update(drawn, scores, floor);
    double best = 0;
    for (const Score& score : scores) best = std::max(best, score.episode_return);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::printf("%10d %16.2f %9.2f %17.3f %8.3f %9.1f\n", generation, scores[0].episode_return,
                best, scores[0].success, static_cast<double>(search.spread.mean()),
                seconds.count());
    std::fflush(stdout);
  }
}

// Episodes that the search has not seen: nothing learned, what was learned.
void compare(const Search& search) {
  engram::VectorEnv env = engram::make(kId, {.num_envs = kTrials,
                                             .control_mode = engram::ControlMode::kPdEeDeltaPos,
                                             .auto_reset = engram::AutoReset::kOff});
  constexpr std::uint64_t kFresh = 1'000'000'000;
  const Score untrained = run(env, {Weights::Zero(kFeatures, kActions)}, kFresh)[0];
  const Score trained = run(env, {search.mean}, kFresh)[0];
  std::printf("untrained: return %.2f, success %.3f\n", untrained.episode_return,
              untrained.success);
  std::printf("trained:   return %.2f, success %.3f\n", trained.episode_return, trained.success);
}

}  // namespace

int main(int argc, char** argv) {
  const int generations = argc > 1 ? std::atoi(argv[1]) : 40;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoi(argv[2]) : 0);
  if (generations < 1) {
    std::fprintf(stderr, "usage: cross_entropy [GENERATIONS, at least 1 [SEED]]\n");
    return 2;
  }
  try {
    Search search(seed);
    learn(search, generations);
    compare(search);
  } catch (const engram::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
