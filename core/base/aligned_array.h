// A fixed-size array on cache-line boundaries, for columns and batch buffers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

namespace engram {

// Owns `size` elements whose first one lies on a 64-byte boundary. They start value-initialised,
// which is zero for numbers, unless they are made without values. Moving leaves an empty array
// behind and keeps pointers valid.
template <typename T>
class AlignedArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  static constexpr std::size_t kAlignment = std::max<std::size_t>(64, alignof(T));

  AlignedArray() = default;

  // Throws std::bad_alloc if memory runs out.
  explicit AlignedArray(std::size_t size) : AlignedArray(uninitialized(size)) {
    std::uninitialized_value_construct_n(data_, size_);
  }

  // Elements have no values yet: what is never used takes up no memory.
  static AlignedArray uninitialized(std::size_t size) {
    AlignedArray array;
    if (size == 0) return array;
    if (size > std::numeric_limits<std::size_t>::max() / sizeof(T)) {
      throw std::bad_array_new_length();
    }
    void* memory = ::operator new (size * sizeof(T), std::align_val_t{kAlignment});
    array.data_ = static_cast<T*>(memory);
    array.size_ = size;
    return array;
  }

  AlignedArray(AlignedArray&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

  AlignedArray& operator=(AlignedArray&& other) noexcept {
    AlignedArray taken(std::move(other));
    std::swap(data_, taken.data_);
    std::swap(size_, taken.size_);
    return *this;
  }

  ~AlignedArray() { ::operator delete (data_, std::align_val_t{kAlignment}); }

  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }

  T* data() noexcept { return data_; }
  const T* data() const noexcept { return data_; }
  T* begin() noexcept { return data_; }
  const T* begin() const noexcept { return data_; }
  T* end() noexcept { return data_ + size_; }
  const T* end() const noexcept { return data_ + size_; }

  // Unchecked.
  T& operator[](std::size_t i) noexcept { return data_[i]; }
  const T& operator[](std::size_t i) const noexcept { return data_[i]; }

  std::span<T> span() noexcept { return {data_, size_}; }
  std::span<const T> span() const noexcept { return {data_, size_}; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace engram
