#include "tasks/trace_shape/chance.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

#include "core/base/index.h"
#include "core/math/random.h"
#include "tasks/trace_shape/contour.h"

namespace engram::tasks {
namespace {

// --- the benchmark's tasks: measured, 6000 and 4000 episodes, by the number of shapes to choose
// from

constexpr std::array<double, 4> kTraceRates = {0, 0.86, 0.53, 0.33};
constexpr std::array<double, 4> kTraceSeqRates = {0, 0.195, 0.083, 0.047};

bool is_benchmark(const TraceParams& params) {
  const TraceParams& own = params.sequence ? kTraceSeqVariants[0] : kTraceVariants[0];
  for (int i = 0; i < params.AVAILABLE_SHAPES.size(); ++i) {
    if (params.AVAILABLE_SHAPES[i] != i) return false;
  }
  return params.contours == own.contours && params.SHAPE_RADIUS_RANGE == own.SHAPE_RADIUS_RANGE &&
         params.MIN_SEQUENCE_LENGTH == own.MIN_SEQUENCE_LENGTH &&
         params.MAX_SEQUENCE_LENGTH == own.MAX_SEQUENCE_LENGTH;
}

// --- other tasks: a point moves nearly as the cube would ---

constexpr int kPurpose = 0;  // of streams of random numbers; no episode is concerned
constexpr int kTrials = 1000;
constexpr int kRounds = 2;                  // of one shape, at most
constexpr int kMaxSteps = 400;              // per shape
constexpr double kStride = 0.025;           // m per control step
constexpr double kResponse = 0.5;           // of a change of pace, in one control step
const Vec2 kStart(GREEN_CUBE_OFFSET_X, 0);  // from the shapes' centre

// What an agent guesses of a demonstration: shapes, sizes and turns, or shapes alone.
enum class Guess { kAll, kShapes };

class Trial {
 public:
  Trial(const TraceParams& params, const ContourSet& set, Guess guess, int number)
      : params_(params), set_(set), random_(0, static_cast<std::uint64_t>(number), kPurpose) {
    shown_ = draw_shapes();
    guessed_ = draw_shapes();
    if (guess == Guess::kAll) return;
    for (std::size_t i = 0; i < guessed_.size(); ++i) {
      guessed_[i] = shown_[std::min(i, shown_.size() - 1)].as(guessed_[i].shape());
    }
  }

  // True if the guess passes for the demonstration.
  bool succeeds() {
    const std::size_t rounds = params_.sequence ? guessed_.size() : kRounds;
    for (std::size_t round = 0; round < rounds; ++round) {
      if (trace(guessed_[params_.sequence ? round : 0])) return true;
    }
    return params_.sequence && closed_ == shown_.size();
  }

 private:
  std::vector<Contour> draw_shapes() {
    std::vector<Contour> shapes;
    const int length = random_.integer(params_.MIN_SEQUENCE_LENGTH, params_.MAX_SEQUENCE_LENGTH);
    for (int i = 0; i < length; ++i) {
      const int shape =
          params_.AVAILABLE_SHAPES[random_.integer(0, params_.AVAILABLE_SHAPES.size() - 1)];
      const double radius =
          random_.uniform(params_.SHAPE_RADIUS_RANGE.low, params_.SHAPE_RADIUS_RANGE.high);
      const double rotation = random_.uniform(0, 2 * std::numbers::pi);
      shapes.emplace_back(set_, shape, radius, rotation, Vec2(0, 0));
    }
    return shapes;
  }

  // Leads the point around one guessed shape. True once that ends an episode with success.
  bool trace(const Contour& guess) {
    int visited = 0;
    for (int step = 0; step < kMaxSteps; ++step) {
      const Vec2 offset = lookahead_point(guess, visited, at_) - at_;
      pace_ += kResponse * (offset * std::min(1.0, kStride / offset.norm()) - pace_);
      at_ += pace_;
      follow();
      if (!params_.sequence && closed_ == shown_.size()) return true;
      visited = visit(guess, at_, visited);
      if (is_closed(guess, at_, visited)) return false;
    }
    return false;
  }

  void follow() {
    if (closed_ == shown_.size()) return;
    visited_ = visit(shown_[closed_], at_, visited_);
    if (!is_closed(shown_[closed_], at_, visited_)) return;
    ++closed_;
    visited_ = 0;
  }

  const TraceParams& params_;
  const ContourSet& set_;
  RandomStream random_;
  std::vector<Contour> shown_;
  std::vector<Contour> guessed_;
  Vec2 at_ = kStart;
  Vec2 pace_ = Vec2::Zero();  // m per control step
  int visited_ = 0;           // of the shape that has to be traced
  std::size_t closed_ = 0;    // shapes
};

double estimate(const TraceParams& params, Guess guess) {
  const ContourSet set(params.contours);
  int successes = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    successes += Trial(params, set, guess, trial).succeeds() ? 1 : 0;
  }
  // Even the least likely answer is given now and then.
  return (successes + 0.5) / (kTrials + 1);
}

}  // namespace

int count_sequences(const TraceParams& params) {
  const double shapes = params.AVAILABLE_SHAPES.size();
  double count = 0;
  double of_length = 1;
  for (int length = 1; length <= params.MAX_SEQUENCE_LENGTH; ++length) {
    of_length *= shapes;
    if (length >= params.MIN_SEQUENCE_LENGTH) count += of_length;
  }
  return static_cast<int>(count);
}

void describe_guess(const TraceParams& params, TaskInfo& info) {
  if (is_benchmark(params)) {
    const auto shapes = at(params.AVAILABLE_SHAPES.size());
    info.guess_rate = params.sequence ? kTraceSeqRates[shapes] : kTraceRates[shapes];
  } else {
    info.estimate_guess = [params] { return estimate(params, Guess::kAll); };
  }
}

double choice_rate(const TraceParams& params) { return estimate(params, Guess::kShapes); }

// A shape is as good as the others; in a sequence, the length has to be right as well.
double answer_rate(const TraceParams& params) {
  const double shapes = params.AVAILABLE_SHAPES.size();
  const int lengths = params.MAX_SEQUENCE_LENGTH - params.MIN_SEQUENCE_LENGTH + 1;
  double right = 1;
  for (int i = 0; i < params.MIN_SEQUENCE_LENGTH; ++i) right /= shapes;
  return right / lengths;
}

}  // namespace engram::tasks
