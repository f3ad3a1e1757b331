// Images of all environments of a batch, one row of values each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "core/base/aligned_array.h"

namespace engram {

template <class T>
class ImageBuffer {
 public:
  ImageBuffer() = default;
  // size: values of one environment. finals: the last images of ended episodes are kept.
  ImageBuffer(std::size_t size, int num_envs, bool finals)
      : size_(size),
        count_(size * static_cast<std::size_t>(num_envs)),
        own_(count_),
        own_finals_(finals ? count_ : 0),
        now_(own_.data()),
        before_(now_),
        finals_(own_finals_.data()) {}

  std::size_t size() const { return size_; }
  std::span<const T> now() const { return {now_, count_}; }
  std::span<const T> finals() const { return {finals_, finals_ != nullptr ? count_ : 0}; }
  T* of(int env) { return now_ + at(env); }

  // Keeps the present image as the one at the episode's end.
  void keep_final(int env) { std::copy_n(of(env), size_, finals_ + at(env)); }

  // Arrays of others take the place of this object's own, whose memory is given back. They outlive
  // this object. Null: as before.
  void draw_into(T* now, T* finals) {
    if (size_ == 0) return;
    if (now != nullptr) {
      own_ = AlignedArray<T>();
      before_ = now_ = now;
    }
    if (finals != nullptr && finals_ != nullptr) {
      own_finals_ = AlignedArray<T>();
      finals_ = finals;
    }
  }
  // The next images go into this array.
  void swap_to(T* now) {
    if (size_ == 0 || now == nullptr) return;
    before_ = now_;
    now_ = now;
  }
  // The image stays as it was before the swap.
  void repeat(int env) {
    if (now_ != before_) std::copy_n(before_ + at(env), size_, of(env));
  }

 private:
  std::size_t at(int env) const { return size_ * static_cast<std::size_t>(env); }

  std::size_t size_ = 0;
  std::size_t count_ = 0;
  AlignedArray<T> own_;
  AlignedArray<T> own_finals_;
  T* now_ = nullptr;
  T* before_ = nullptr;  // where the images before the last swap are
  T* finals_ = nullptr;
};

}  // namespace engram
