// Rows and matrices over the robot's nine joints, for a single robot or for many side by side, and
// loops over them without a loop.
#pragma once

#include <type_traits>

#include "core/math/simd.h"
#include "core/robot/robot_model.h"

// After a lambda's parameters.
#define ENGRAM_INLINE_LAMBDA __attribute__((always_inline))

namespace engram {
inline namespace ENGRAM_ISA {

// A number that the compiler knows.
template <int kIndex>
struct Index {
  constexpr operator int() const { return kIndex; }
};
// Visits 0 to kCount - 1 in order, each with code of its own: what a loop would keep in memory,
// since it is indexed, stays in registers.
template <int kCount, int kFirst = 0, class Visit>
ENGRAM_INLINE void for_each_index(const Visit& visit) {
  if constexpr (kFirst < kCount) {
    visit(Index<kFirst>());
    for_each_index<kCount, kFirst + 1>(visit);
  }
}
template <class Visit>
ENGRAM_INLINE void for_each_joint(const Visit& visit) {
  for_each_index<kRobotJoints>(visit);
}

// Rows are computed in groups of entries, each a vector: of robots side by side, a single entry; of
// a single robot, as many entries as a vector has.
template <class V>
using WideOf = std::conditional_t<std::is_same_v<V, float>, simd::Float,
                                  std::conditional_t<std::is_same_v<V, double>, simd::Double, V>>;
template <class V>
constexpr int kGroup = simd::kLanesOf<WideOf<V>> / simd::kLanesOf<V>;

// Copies a number to all entries of a group.
template <class V>
ENGRAM_INLINE WideOf<V> spread(V value) {
  if constexpr (kGroup<V> == 1) {
    return value;
  } else {
    return simd::broadcast<WideOf<V>>(value);
  }
}

// A group of a row that begins here, anywhere in memory.
template <class V>
struct [[gnu::packed, gnu::may_alias]] GroupOf {
  WideOf<V> wide;

  ENGRAM_INLINE static GroupOf& at(V * row) { return *reinterpret_cast<GroupOf*>(row); }
  ENGRAM_INLINE static const GroupOf& at(const V* row) {
    return *reinterpret_cast<const GroupOf*>(row);
  }
};

// A row may be longer than its entries are many: it has whole groups, and zeros at its end.
template <class V, int kCount>
constexpr int kPadded = (kCount + kGroup<V> - 1) / kGroup<V>* kGroup<V>;

template <class V, int kCount>
struct RowOf {
  V at[kPadded<V, kCount>] = {};
  V& operator[](int i) { return at[i]; }
  const V& operator[](int i) const { return at[i]; }
  const V* begin() const { return at; }
  const V* end() const { return at + kPadded<V, kCount>; }

  // The group that begins with entry `first`.
  ENGRAM_INLINE WideOf<V> group(int first) const { return GroupOf<V>::at(at + first).wide; }
  ENGRAM_INLINE void set_group(int first, WideOf<V> value) {
    GroupOf<V>::at(at + first).wide = value;
  }
};
template <class V>
using JointsOf = RowOf<V, kRobotJoints>;

// Rows of structures that consist of numbers only: a row for each number. To begin with, only the
// rows' ends have values.
template <class V, template <class> class Struct, int kCount>
class RowsOf {
 public:
  ENGRAM_INLINE RowsOf() {
    for (auto& row : rows_) {
      for (int i = kCount; i < kPadded<V, kCount>; ++i) row[i] = V{};
    }
  }

  ENGRAM_INLINE Struct<V> operator[](int i) const {
    Struct<V> value;
    for (int k = 0; k < kRows; ++k) reinterpret_cast<V*>(&value)[k] = rows_[k][i];
    return value;
  }
  ENGRAM_INLINE void set(int i, const Struct<V>& value) {
    for (int k = 0; k < kRows; ++k) rows_[k][i] = reinterpret_cast<const V*>(&value)[k];
  }
  // The group that begins with entry `first`.
  ENGRAM_INLINE Struct<WideOf<V>> group(int first) const {
    Struct<WideOf<V>> value;
    for (int k = 0; k < kRows; ++k) {
      reinterpret_cast<WideOf<V>*>(&value)[k] = GroupOf<V>::at(rows_[k] + first).wide;
    }
    return value;
  }
  ENGRAM_INLINE void set_group(int first, const Struct<WideOf<V>>& value) {
    for (int k = 0; k < kRows; ++k) {
      GroupOf<V>::at(rows_[k] + first).wide = reinterpret_cast<const WideOf<V>*>(&value)[k];
    }
  }

 private:
  static constexpr int kRows = sizeof(Struct<V>) / sizeof(V);
  V rows_[kRows][kPadded<V, kCount>];
};

// Copies a number to all entries of a group.
template <template <class> class Struct, class V>
ENGRAM_INLINE Struct<WideOf<V>> spread(const Struct<V>& value) {
  Struct<WideOf<V>> wide;
  for (int k = 0; k < static_cast<int>(sizeof(Struct<V>) / sizeof(V)); ++k) {
    reinterpret_cast<WideOf<V>*>(&wide)[k] = spread(reinterpret_cast<const V*>(&value)[k]);
  }
  return wide;
}

// row += scale * other
template <class V>
ENGRAM_INLINE void add_scaled(JointsOf<V>& row, V scale, const JointsOf<V>& other) {
  for_each_joint([&](auto i) ENGRAM_INLINE_LAMBDA { row[i] += scale * other[i]; });
}

template <class V>
struct JointMatrixOf {
  JointsOf<V> row[kRobotJoints];
  JointsOf<V>& operator[](int i) { return row[i]; }
  const JointsOf<V>& operator[](int i) const { return row[i]; }
  const JointsOf<V>* begin() const { return row; }
  const JointsOf<V>* end() const { return row + kRobotJoints; }
};

// A row over the joints in registers.
template <class V>
struct WideRow {
  static constexpr int kEntries = kGroup<V>;
  static constexpr int kVectors = kPadded<V, kRobotJoints> / kGroup<V>;

  ENGRAM_INLINE explicit WideRow(const JointsOf<V>& row) {
    for_each_index<kVectors>([&](auto i) ENGRAM_INLINE_LAMBDA { at[i] = row.group(kEntries * i); });
  }
  ENGRAM_INLINE void store(JointsOf<V>& row) const {
    for_each_index<kVectors>([&](auto i)
                                 ENGRAM_INLINE_LAMBDA { row.set_group(kEntries * i, at[i]); });
  }

  // A joint's entry.
  template <int kJoint>
  ENGRAM_INLINE V entry() const {
    if constexpr (kEntries == 1) {
      return at[kJoint];
    } else {
      return at[kJoint / kEntries][kJoint % kEntries];
    }
  }
  template <int kJoint>
  ENGRAM_INLINE void set(V value) {
    if constexpr (kEntries == 1) {
      at[kJoint] = value;
    } else {
      at[kJoint / kEntries][kJoint % kEntries] = value;
    }
  }

  // += scale * other
  ENGRAM_INLINE void add_scaled(V scale, const WideRow& other) {
    const WideOf<V> factor = spread(scale);
    for_each_index<kVectors>([&](auto i) ENGRAM_INLINE_LAMBDA { at[i] += factor * other.at[i]; });
  }

  WideOf<V> at[kVectors];
};

// Gauss-Jordan elimination of a symmetric positive definite matrix, which needs no pivoting. Row by
// row, each in registers.
template <class V>
ENGRAM_INLINE void invert(JointMatrixOf<V>& m) {
  using Row = WideRow<V>;
  const auto eliminate = [&m](Row& row, auto pivot) ENGRAM_INLINE_LAMBDA {
    const Row pivot_row(m[pivot]);
    const auto factor = -spread(row.template entry<pivot>());
    row.template set<pivot>(V{});
    for_each_index<Row::kVectors>(
        [&](auto e) ENGRAM_INLINE_LAMBDA { row.at[e] += factor * pivot_row.at[e]; });
  };
  for_each_joint([&](auto k) ENGRAM_INLINE_LAMBDA {
    Row row(m[k]);
    for_each_joint([&](auto i) ENGRAM_INLINE_LAMBDA {
      if constexpr (i < k) eliminate(row, i);
    });
    const auto scale = 1.0F / spread(row.template entry<k>());
    row.template set<k>(simd::broadcast<V>(1));
    for_each_index<Row::kVectors>([&](auto e) ENGRAM_INLINE_LAMBDA { row.at[e] *= scale; });
    row.store(m[k]);
  });
  for_each_joint([&](auto k) ENGRAM_INLINE_LAMBDA {
    Row row(m[k]);
    for_each_joint([&](auto i) ENGRAM_INLINE_LAMBDA {
      if constexpr (i > k) eliminate(row, i);
    });
    row.store(m[k]);
  });
}

}  // namespace ENGRAM_ISA
}  // namespace engram
