#include "mjcf/xml.h"

#include <charconv>
#include <cmath>

#include "core/math/rotations.h"

namespace engram::mjcf {
namespace {

// The shortest text that reads back as the same double.
std::string to_text(double number) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
  return {buffer.data(), result.ptr};
}

double computed_norm(const Eigen::Vector4d& q) {
  return std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

}  // namespace

Element& add(Element& parent, const char* tag) { return *parent.InsertNewChildElement(tag); }

void set(Element& element, const char* attribute, const std::string& text) {
  element.SetAttribute(attribute, text.c_str());
}

void set(Element& element, const char* attribute, std::span<const double> numbers) {
  std::string text;
  for (const double number : numbers) {
    if (!text.empty()) text += ' ';
    text += to_text(number);
  }
  set(element, attribute, text);
}

void set(Element& element, const char* attribute, std::initializer_list<double> numbers) {
  set(element, attribute, std::span<const double>(numbers.begin(), numbers.size()));
}

void set(Element& element, const char* attribute, double number) {
  set(element, attribute, {number});
}

void set_rotation(Element& element, const Eigen::Quaterniond& rotation) {
  const Eigen::Quaterniond unit = rotation.normalized();
  Eigen::Vector4d q(unit.w(), unit.x(), unit.y(), unit.z());
  if (q == Eigen::Vector4d(1, 0, 0, 0)) return;
  int largest = 0;
  q.cwiseAbs().maxCoeff(&largest);
  // A last bit of the largest component changes the norm by less than rounding forgives.
  constexpr int kMaxSteps = 8;
  double norm = computed_norm(q);
  for (int i = 0; i < kMaxSteps && norm != 1; ++i, norm = computed_norm(q)) {
    q[largest] = std::nextafter(q[largest], norm > 1 ? 0 : 2 * q[largest]);
  }
  set(element, "quat", {q[0], q[1], q[2], q[3]});
}

void set_rotation(Element& element, const std::array<double, 3>& rpy) {
  using Axis = Eigen::Vector3d;
  set_rotation(element, turn_about(Axis::UnitZ(), rpy[2]) * turn_about(Axis::UnitY(), rpy[1]) *
                            turn_about(Axis::UnitX(), rpy[0]));
}

void add_inertial(Element& body, double mass, const std::array<double, 3>& center,
                  const std::array<double, 6>& inertia) {
  const auto [xx, yy, zz, xy, xz, yz] = inertia;
  Eigen::Vector3d moments(xx, yy, zz);
  Mat3 axes = Mat3::Identity();
  if (xy != 0 || xz != 0 || yz != 0) {
    const Eigen::SelfAdjointEigenSolver<Mat3> solved(
        Mat3{{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}});
    moments = solved.eigenvalues();
    axes = solved.eigenvectors();
    if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  }
  Element& element = add(body, "inertial");
  set(element, "mass", mass);
  set(element, "pos", center);
  set_rotation(element, Eigen::Quaterniond(axes));
  set(element, "diaginertia", {moments[0], moments[1], moments[2]});
}

}  // namespace engram::mjcf
