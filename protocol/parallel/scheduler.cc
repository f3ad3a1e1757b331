#include "protocol/parallel/scheduler.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <map>
#include <utility>
#include <vector>

#include "core/threads/processors.h"
#include "core/threads/thread_pool.h"
#include "protocol/parallel/worker_pool.h"

namespace engram {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTick{100};
// Sleep of a rank between polls for messages. A blocking receive would keep a core busy that the
// workers need.
constexpr std::chrono::milliseconds kPoll{1};

// --- messages ---

enum class MessageType : std::uint8_t {
  kReady,   // to rank 0: number of threads
  kItem,    // to a worker: number, item
  kStop,    // to a worker: number
  kResult,  // to rank 0: number, result
  kFailed,  // to rank 0: number, kind of error, message
  kEnd,     // to a worker: nothing more will come
  kLeft,    // to rank 0: the last message
  kDone,    // to rank 0: number, env steps so far
};

ByteWriter begin_message(MessageType type) {
  ByteWriter out;
  out.put(static_cast<std::uint8_t>(type));
  return out;
}

// --- rank 0 ---

class Coordinator {
 public:
  Coordinator(Ranks& ranks, int threads, const WorkFunction& work, WorkSource& source)
      : ranks_(ranks),
        source_(source),
        workers_(threads, work),
        rank_states_(static_cast<std::size_t>(ranks.size())) {
    rank_states_[0].threads = threads;
  }

  void run() {
    while (true) {
      assign_items();
      if (in_progress_.empty()) break;
      take_reports(workers_.wait(ranks_.is_single() ? kTick : kPoll));
      rank_states_[0].env_steps = workers_.env_steps();
      receive_messages();
      stop_obsolete();
      tick();
    }
    end_ranks();
  }

 private:
  struct RankState {
    int threads = 0;  // 0: unknown so far
    int in_progress = 0;
    std::uint64_t env_steps = 0;
    bool left = false;
  };
  struct Assignment {
    WorkItem item;
    int rank = 0;
    bool stopped = false;
  };

  // One item to each rank in turn, until all threads have one or there is nothing.
  void assign_items() {
    for (bool any = true; any;) {
      any = false;
      for (std::size_t rank = 0; rank < rank_states_.size(); ++rank) {
        RankState& state = rank_states_[rank];
        if (state.in_progress >= state.threads) continue;
        const std::optional<WorkItem> item = source_.next();
        if (!item) return;
        ++state.in_progress;
        any = true;
        in_progress_[++last_number_] = {*item, static_cast<int>(rank), false};
        if (rank == 0) {
          workers_.start(last_number_, *item);
          continue;
        }
        ByteWriter message = begin_message(MessageType::kItem);
        message.put(last_number_);
        message.put(item->task);
        message.put(item->first_seed);
        message.put(item->count);
        message.put(item->repeat);
        ranks_.send(static_cast<int>(rank), message.take());
      }
    }
  }

  // A failure ends the run once all results beside it are taken.
  void take_reports(std::vector<WorkReport> reports) {
    std::exception_ptr failure;
    for (WorkReport& report : reports) {
      if (report.error) {
        failure = report.error;
      } else if (report.finished) {
        end_item(report.number);
      } else {
        accept_result(report.number, std::move(report.result));
      }
    }
    if (failure) std::rethrow_exception(failure);
  }

  Assignment& assignment_of(std::uint64_t number) {
    const auto found = in_progress_.find(number);
    if (found == in_progress_.end()) throw Error(Error::kInternal, "a result of an unknown item");
    return found->second;
  }

  void accept_result(std::uint64_t number, Bytes result) {
    const Assignment& assignment = assignment_of(number);
    if (!assignment.stopped) source_.accept(assignment.item, std::move(result));
  }

  void end_item(std::uint64_t number) {
    --rank_states_[static_cast<std::size_t>(assignment_of(number).rank)].in_progress;
    in_progress_.erase(number);
  }

  void receive_messages() {
    while (std::optional<Ranks::Message> message = ranks_.receive()) {
      RankState& state = rank_states_.at(static_cast<std::size_t>(message->from));
      ByteReader in(message->bytes);
      switch (static_cast<MessageType>(in.get<std::uint8_t>())) {
        case MessageType::kReady:
          state.threads = in.get<int>();
          break;
        case MessageType::kResult: {
          const auto number = in.get<std::uint64_t>();
          accept_result(number, {in.rest().begin(), in.rest().end()});
          break;
        }
        case MessageType::kDone:
          end_item(in.get<std::uint64_t>());
          state.env_steps = in.get<std::uint64_t>();
          break;
        case MessageType::kFailed: {
          const auto kind = static_cast<Error::Kind>(in.get<int>());
          throw Error(kind, "rank " + std::to_string(message->from) + ": " + in.text());
        }
        case MessageType::kLeft:
          state.left = true;
          break;
        default:
          throw Error(Error::kInternal, "a message that rank 0 does not know");
      }
    }
  }

  void stop_obsolete() {
    for (auto& [number, assignment] : in_progress_) {
      if (assignment.stopped || !source_.obsolete(assignment.item)) continue;
      assignment.stopped = true;
      if (assignment.rank == 0) {
        workers_.stop(number);
        continue;
      }
      ByteWriter message = begin_message(MessageType::kStop);
      message.put(number);
      ranks_.send(assignment.rank, message.take());
    }
  }

  void tick() {
    const Clock::time_point now = Clock::now();
    if (now < next_tick_) return;
    next_tick_ = now + kTick;
    WorkStatus status;
    status.in_progress = static_cast<int>(in_progress_.size());
    for (const RankState& state : rank_states_) status.env_steps += state.env_steps;
    source_.tick(status);
  }

  // Waits for the last message of every rank, so that none is left unread.
  void end_ranks() {
    for (int rank = 1; rank < ranks_.size(); ++rank)
      ranks_.send(rank, begin_message(MessageType::kEnd).take());
    rank_states_[0].left = true;
    while (!std::all_of(rank_states_.begin(), rank_states_.end(),
                        [](const RankState& state) { return state.left; })) {
      receive_messages();
      std::this_thread::sleep_for(kPoll);
    }
  }

  Ranks& ranks_;
  WorkSource& source_;
  std::map<std::uint64_t, Assignment> in_progress_;
  std::uint64_t last_number_ = 0;
  Clock::time_point next_tick_{};
  WorkerPool workers_;
  std::vector<RankState> rank_states_;
};

// --- the other ranks ---

void send_report(Ranks& ranks, const WorkReport& report, std::uint64_t env_steps) {
  if (!report.error) {
    ByteWriter message = begin_message(report.finished ? MessageType::kDone : MessageType::kResult);
    message.put(report.number);
    if (report.finished) message.put(env_steps);
    message.append(std::span<const std::byte>(report.result));
    ranks.send(0, message.take());
    return;
  }
  auto kind = Error::kInternal;
  std::string text = "unknown failure";
  try {
    std::rethrow_exception(report.error);
  } catch (const Error& error) {
    kind = error.kind();
    text = error.what();
  } catch (const std::bad_alloc&) {
    kind = Error::kUnavailable;
    text = "out of memory";
  } catch (const std::exception& error) {
    text = error.what();
  }
  ByteWriter message = begin_message(MessageType::kFailed);
  message.put(static_cast<int>(kind));
  message.put(std::string_view(text));
  ranks.send(0, message.take());
}

void run_worker_rank(Ranks& ranks, int threads, const WorkFunction& work) {
  WorkerPool workers(threads, work);
  ByteWriter ready = begin_message(MessageType::kReady);
  ready.put(threads);
  ranks.send(0, ready.take());
  while (true) {
    for (const WorkReport& report : workers.wait(kPoll)) {
      send_report(ranks, report, workers.env_steps());
    }
    while (std::optional<Ranks::Message> message = ranks.receive()) {
      ByteReader in(message->bytes);
      switch (static_cast<MessageType>(in.get<std::uint8_t>())) {
        case MessageType::kItem: {
          const auto number = in.get<std::uint64_t>();
          WorkItem item;
          item.task = in.get<int>();
          item.first_seed = in.get<std::uint64_t>();
          item.count = in.get<int>();
          item.repeat = in.get<int>();
          workers.start(number, item);
          break;
        }
        case MessageType::kStop:
          workers.stop(in.get<std::uint64_t>());
          break;
        case MessageType::kEnd:
          ranks.send(0, begin_message(MessageType::kLeft).take());
          return;
        default:
          throw Error(Error::kInternal, "a message that this rank does not know");
      }
    }
  }
}

}  // namespace

int worker_threads(int threads, const Ranks& ranks) {
  if (threads > 0) return std::min(threads, ThreadPool::kMaxThreads);
  const int cores = available_processors();
  return std::clamp(cores / ranks.local_size(), 1, ThreadPool::kMaxThreads);
}

void distribute_work(Ranks& ranks, int threads, const WorkFunction& work, WorkSource& source) {
  threads = worker_threads(threads, ranks);
  if (!ranks.is_root()) {
    run_worker_rank(ranks, threads, work);
    return;
  }
  Coordinator(ranks, threads, work, source).run();
}

}  // namespace engram
