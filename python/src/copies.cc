#include "copies.h"

#include <cstdint>
#include <cstring>
#include <iterator>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

namespace engram_python {
namespace {

constexpr std::align_val_t kAlignment{64};
// Loops hold two or three observations; more released arrays are freed.
constexpr std::size_t kMaxSpare = 4;

struct Free {
  void operator()(std::uint8_t* bytes) const { ::operator delete(bytes, kAlignment); }
};

struct Block {
  std::unique_ptr<std::uint8_t, Free> bytes;
  std::size_t size = 0;
};

}  // namespace

// Arrays may die in any thread.
class Copies::Store {
 public:
  Store() { spare_.reserve(kMaxSpare); }

  Block take(std::size_t size) {
    {
      const std::lock_guard lock(mutex_);
      for (auto block = spare_.rbegin(); block != spare_.rend(); ++block) {
        if (block->size != size) continue;
        Block taken = std::move(*block);
        spare_.erase(std::next(block).base());
        return taken;
      }
    }
    auto* bytes = static_cast<std::uint8_t*>(::operator new(size, kAlignment));
    return {std::unique_ptr<std::uint8_t, Free>(bytes), size};
  }

  void give_back(Block block) {
    const std::lock_guard lock(mutex_);
    if (spare_.size() < kMaxSpare) spare_.push_back(std::move(block));
  }

  std::size_t spare() const {
    const std::lock_guard lock(mutex_);
    std::size_t bytes = 0;
    for (const Block& block : spare_) bytes += block.size;
    return bytes;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Block> spare_;
};

Copies::Copies() : store_(std::make_shared<Store>()) {}

std::size_t Copies::spare() const { return store_->spare(); }

nb::object Copies::copy(const Array& array) {
  struct Lent {
    std::shared_ptr<Store> store;
    Block block;
  };
  auto lent = std::make_unique<Lent>(Lent{store_, store_->take(array.nbytes())});
  std::uint8_t* data = lent->block.bytes.get();
  std::memcpy(data, array.data(), array.nbytes());
  const nb::capsule owner(lent.get(), [](void* held) noexcept {
    const std::unique_ptr<Lent> back(static_cast<Lent*>(held));
    back->store->give_back(std::move(back->block));
  });
  lent.release();
  std::vector<std::size_t> shape;
  for (std::size_t i = 0; i < array.ndim(); ++i) shape.push_back(array.shape(i));
  return nb::cast(
      nb::ndarray<nb::numpy>(data, shape.size(), shape.data(), owner, nullptr, array.dtype()));
}

}  // namespace engram_python
