// Ranks of MPI; loaded by join_ranks() where a launcher has started several processes.
#include <mpi.h>

#include <deque>
#include <string>

#include "core/base/error.h"
#include "protocol/parallel/ranks.h"

namespace engram {
namespace {

constexpr int kTag = 1;

void require(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw Error(Error::kUnavailable,
              std::string(what) + ": " + std::string(text, static_cast<std::size_t>(length)));
}

class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    // All calls come from the thread that joined; workers are threads of their own.
    int provided = MPI_THREAD_SINGLE;
    require(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "MPI_Init");
    if (provided < MPI_THREAD_FUNNELED) {
      throw Error(Error::kUnavailable, "MPI: this installation does not allow threads");
    }
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    MPI_Comm neighbours = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &neighbours);
    MPI_Comm_size(neighbours, &local_size_);
    MPI_Comm_free(&neighbours);
  }

  // A rank that is destroyed while an exception passes leaves the others waiting, so it calls
  // abort() before.
  ~MpiRanks() override {
    for (Sending& sending : sendings_) MPI_Wait(&sending.request, MPI_STATUS_IGNORE);
    MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int local_size() const override { return local_size_; }

  void send(int to, Bytes bytes) override {
    // Its elements stay where they are until MPI is done with them.
    Sending& sending = sendings_.emplace_back();
    sending.bytes = std::move(bytes);
    if (sending.bytes.size() > kLargest) throw Error(Error::kInternal, "a message over 1 GiB");
    require(MPI_Isend(sending.bytes.data(), static_cast<int>(sending.bytes.size()), MPI_BYTE, to,
                      kTag, MPI_COMM_WORLD, &sending.request),
            "MPI_Isend");
  }

  std::optional<Message> receive() override {
    release_sent();
    int arrived = 0;
    MPI_Status status;
    require(MPI_Iprobe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &arrived, &status), "MPI_Iprobe");
    if (arrived == 0) return std::nullopt;
    int count = 0;
    MPI_Get_count(&status, MPI_BYTE, &count);
    Message message{status.MPI_SOURCE, Bytes(static_cast<std::size_t>(count))};
    require(MPI_Recv(message.bytes.data(), count, MPI_BYTE, status.MPI_SOURCE, kTag, MPI_COMM_WORLD,
                     MPI_STATUS_IGNORE),
            "MPI_Recv");
    return message;
  }

  void abort() override { MPI_Abort(MPI_COMM_WORLD, 1); }

 private:
  static constexpr std::size_t kLargest = std::size_t{1} << 30;
  struct Sending {
    Bytes bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };

  void release_sent() {
    while (!sendings_.empty()) {
      int sent = 0;
      require(MPI_Test(&sendings_.front().request, &sent, MPI_STATUS_IGNORE), "MPI_Test");
      if (sent == 0) return;
      sendings_.pop_front();
    }
  }

  int rank_ = 0;
  int size_ = 1;
  int local_size_ = 1;
  std::deque<Sending> sendings_;
};

}  // namespace
}  // namespace engram

extern "C" __attribute__((visibility("default"))) engram::Ranks* engram_join_mpi() {
  return new engram::MpiRanks;
}
