// Rows and matrices over the robot's nine joints, for a single robot or for many side by side, and
// loops over them without a loop.
#pragma once

#include <type_traits>

#include "core/math/simd.h"
#include "core/robot/robot_params.h"

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

// Rows may be longer than the joints are many: a single robot's are whole vectors so, and have
// zeros at their ends.
template <class V>
constexpr int kJointRow = simd::kLanesOf<V> > 1 ? kRobotJoints
                                                : kRobotJoints + simd::kDoubles - 1 -
                                                      (kRobotJoints - 1) % simd::kDoubles;
template <class V>
struct JointsOf {
  V at[kJointRow<V>] = {};
  V& operator[](int i) { return at[i]; }
  const V& operator[](int i) const { return at[i]; }
  const V* begin() const { return at; }
  const V* end() const { return at + kJointRow<V>; }
};

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

// A row as whole vectors: of robots side by side, or of a single robot's joints.
template <class V>
struct WideRow {
  using Wide = std::conditional_t<simd::kLanesOf<V> == 1, simd::Double, V>;
  static constexpr int kEntries = simd::kLanesOf<Wide> / simd::kLanesOf<V>;  // of a vector
  static constexpr int kVectors = kJointRow<V> / kEntries;

  ENGRAM_INLINE explicit WideRow(const JointsOf<V>& row) {
    for_each_index<kVectors>([&](auto i) ENGRAM_INLINE_LAMBDA {
      at[i] = reinterpret_cast<const Entries*>(row.at)[i].wide;
    });
  }
  ENGRAM_INLINE void store(JointsOf<V>& row) const {
    for_each_index<kVectors>(
        [&](auto i) ENGRAM_INLINE_LAMBDA { reinterpret_cast<Entries*>(row.at)[i].wide = at[i]; });
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
  // A joint's entry, in all entries of a vector.
  template <int kJoint>
  ENGRAM_INLINE Wide get() const {
    return spread(entry<kJoint>());
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
    const Wide factor = spread(scale);
    for_each_index<kVectors>([&](auto i) ENGRAM_INLINE_LAMBDA { at[i] += factor * other.at[i]; });
  }

  ENGRAM_INLINE static Wide spread(V value) {
    if constexpr (kEntries == 1) {
      return value;
    } else {
      return simd::broadcast<Wide>(value);
    }
  }

  // Lies anywhere.
  struct [[gnu::packed, gnu::may_alias]] Entries {
    Wide wide;
  };

  Wide at[kVectors];
};

// Gauss-Jordan elimination of a symmetric positive definite matrix, which needs no pivoting. Row by
// row, each in registers.
template <class V>
ENGRAM_INLINE void invert(JointMatrixOf<V>& m) {
  using Row = WideRow<V>;
  const auto eliminate = [&m](Row& row, auto pivot) ENGRAM_INLINE_LAMBDA {
    const Row pivot_row(m[pivot]);
    const auto factor = -row.template get<pivot>();
    row.template set<pivot>(V{});
    for_each_index<Row::kVectors>(
        [&](auto e) ENGRAM_INLINE_LAMBDA { row.at[e] += factor * pivot_row.at[e]; });
  };
  for_each_joint([&](auto k) ENGRAM_INLINE_LAMBDA {
    Row row(m[k]);
    for_each_joint([&](auto i) ENGRAM_INLINE_LAMBDA {
      if constexpr (i < k) eliminate(row, i);
    });
    const auto scale = 1.0 / row.template get<k>();
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
