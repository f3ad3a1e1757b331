#include "tasks/trace_shape/demo.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

namespace engram::tasks {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

constexpr mjcf::Rgba kRed = {220 / 255.0, 50 / 255.0, 50 / 255.0, 1};
constexpr mjcf::Rgba kGreen = {50 / 255.0, 220 / 255.0, 50 / 255.0, 1};
constexpr LampLight kOff = {{245 / 255.0, 245 / 255.0, 245 / 255.0, 1}, 0};
constexpr LampLight kRedLight = {{1, 0, 0, 1}, 20};
constexpr LampLight kGreenLight = {{0, 1, 0, 1}, 20};

// Half the side in images, m: where it is inside the green cube, its faces are in front.
constexpr double kSeenHalfSize = CUBE_HALFSIZE + 0.0005;

// The visible red cube touches nothing: if the green cube were pushed, its place would tell
// afterwards what has been traced.
mjcf::Prop red_cube_prop() {
  mjcf::Prop cube = mjcf::cube("red_cube", kSeenHalfSize, kRed);
  cube.body_type = mjcf::BodyType::kKinematic;
  cube.geoms.front().collides = false;
  cube.pos = {0.1, 0, CUBE_HALFSIZE};
  return cube;
}

mjcf::Prop red_body_prop() {
  mjcf::Prop cube = mjcf::cube("red_cube_body", CUBE_HALFSIZE, kRed);
  cube.body_type = mjcf::BodyType::kKinematic;
  cube.pushes_props = true;
  cube.geoms.front().visible = false;
  cube.pos = {0.1, 0, CUBE_HALFSIZE};
  return cube;
}

mjcf::Prop green_cube_prop() {
  mjcf::Prop cube = mjcf::cube("green_cube", CUBE_HALFSIZE, kGreen);
  cube.pos = {-0.26, 0, CUBE_HALFSIZE};
  return cube;
}

// Meanings of pinned values, or values of the variable's stream.
template <class Meaning, class Sample, class T>
void draw_values(const Episode& episode, const VariableHandle& variable, T* values, int count,
                 Meaning meaning, Sample sample) {
  if (const double* pinned = variable.pinned(episode)) {
    std::transform(pinned, pinned + count, values, meaning);
    return;
  }
  RandomStream random = variable.stream(episode);
  std::generate_n(values, count, [&] { return sample(random); });
}

// "0 circle, 1 square".
std::string in_words(const NameList& shapes) {
  std::string words;
  for (int i = 0; i < shapes.size(); ++i) {
    words += (i == 0 ? "" : ", ") + std::to_string(i) + " " + kContourNames[at(shapes[i])];
  }
  return words;
}

double draw_rotation(RandomStream& random) { return random.uniform(0, kTurn); }

}  // namespace

Vec2 clear_of_red(const Vec2& green, const Vec2& red, const Vec2& half) {
  constexpr double kGap = 0.0005;  // m
  const Vec2 offset = green - red;
  const Vec2 overlap = half + Vec2::Constant(CUBE_HALFSIZE);
  if (std::abs(offset.x()) >= overlap.x() || std::abs(offset.y()) >= overlap.y()) return green;
  const double clear = overlap.y() + kGap;
  return {green.x(), red.y() + (offset.y() >= 0 ? clear : -clear)};
}

TraceVariables::TraceVariables(RandomVariables list, const TraceParams& params)
    : shapes(
          list.add({params.sequence ? "shapes" : "shape", params.MAX_SEQUENCE_LENGTH, true, 0,
                    params.AVAILABLE_SHAPES.size() - 1.0, "", in_words(params.AVAILABLE_SHAPES)})),
      radii(list.of(params.SHAPE_RADIUS_RANGE, params.MAX_SEQUENCE_LENGTH)),
      center_x(list.real("center_x", SHAPE_CENTER_X_RANGE, "m", "of every shape")),
      center_y(list.real("center_y", SHAPE_CENTER_Y_RANGE, "m", "of every shape")),
      rotations(list.add({params.sequence ? "rotations" : "rotation", params.MAX_SEQUENCE_LENGTH,
                          false, 0, kTurn, "rad", ""})),
      pre_demo_steps(list.of(params.PRE_DEMO_STEPS)) {
  if (!params.sequence) return;
  length = list.integer("sequence_length", {params.MIN_SEQUENCE_LENGTH, params.MAX_SEQUENCE_LENGTH},
                        "", "how many of the shapes are shown");
}

TraceDemo::TraceDemo(mjcf::Scene& scene, TaskInfo& info, const TraceParams& params)
    : params_(params),
      variables_(RandomVariables(info.random_variables), params),
      red_pushes_green_(
          TaskOptions(info.options)
              .on_off("red_pushes_green",
                      "1: the red cube has a body and pushes the green one while that is awake",
                      /*original=*/true)),
      contours_(params.contours),
      red_(static_cast<int>(scene.props.size())),
      green_(red_ + 1),
      red_body_(green_ + 1) {
  scene.render_view = mjcf::RenderView::kTable;
  scene.props.push_back(red_cube_prop());
  scene.props.push_back(green_cube_prop());
  lamp_ = Lamp(scene, "lamp");
  red_body_ = static_cast<int>(scene.props.size());
  scene.props.push_back(red_body_prop());
}

void TraceDemo::bind(const Bindings& bindings) {
  engine_ = bindings;
  pushes_ = red_pushes_green_.is_on(bindings);
  ColumnStore& memory = *bindings.memory;
  const int most = params_.MAX_SEQUENCE_LENGTH;
  length_ = memory.add<std::int32_t>("sequence_length");
  shapes_ = memory.add<std::int32_t>("shapes", most);
  memory.limit("sequence_length", 1, most);
  memory.limit("shapes", -1, kContourShapes - 1);  // -1: beyond the sequence's end
  radii_ = memory.add<double>("radii", most, "m");
  rotations_ = memory.add<double>("rotations", most, "rad");
  center_ = memory.add<double>("center", 2, "m");
  pre_demo_steps_ = memory.add<std::int32_t>("pre_demo_steps", 1, "control steps");
}

// --- sampling ---

void TraceDemo::reset(const Episode& episode) const {
  const int env = episode.env();
  const int most = params_.MAX_SEQUENCE_LENGTH;
  draw_values(
      episode, variables_.shapes, shapes_.row(env), most,
      [this](double pinned) { return params_.AVAILABLE_SHAPES[static_cast<int>(pinned)]; },
      [this](RandomStream& random) { return draw_shape(random); });
  const Interval<double> radii = variables_.radii.interval(episode);
  draw_values(episode, variables_.radii, radii_.row(env), most, std::identity(),
              [&](RandomStream& random) { return random.uniform(radii.low, radii.high); });
  draw_values(episode, variables_.rotations, rotations_.row(env), most, std::identity(),
              draw_rotation);
  center_.row(env)[0] = variables_.center_x.sample(episode);
  center_.row(env)[1] = variables_.center_y.sample(episode);
  pre_demo_steps_[env] = variables_.pre_demo_steps.sample(episode);
  length_[env] = variables_.length ? variables_.length->sample(episode) : 1;
  std::fill(shapes_.row(env) + length_[env], shapes_.row(env) + most, -1);

  const Vec2 stand = lamp_at(env);
  const double lamp_pos[3] = {stand.x(), stand.y(), 0};
  lamp_.place(*engine_.state, env, lamp_pos);
  put_red(env, {});
  put_green(env);
}

// --- phases ---

TracePhase TraceDemo::phase(int env) const {
  const int elapsed = engine_.state->elapsed[env];
  if (elapsed < pre_demo_steps_[env]) return TracePhase::kPreDemo;
  return elapsed < demo_end(env) ? TracePhase::kDemo : TracePhase::kAction;
}

void TraceDemo::advance(int env) const {
  const int elapsed = engine_.state->elapsed[env];
  const int end = demo_end(env);
  light_lamp(env);
  if (elapsed < end) {
    const Place place = place_at(env, elapsed);
    put_red(env, place);
    const bool jumps = place.element > 0 && place.waypoint == 0;
    if (pushes_ && jumps && engine_.state->status_of(env, green_) == PropStatus::kAwake) {
      make_room_for_red(env);
    }
  } else if (elapsed == end) {
    const double* last = engine_.state->prop_pos_of(env, red_);
    const double hidden[3] = {last[0], last[1], CUBE_HALFSIZE + kTraceHiddenOffset};
    engine_.state->hide_prop(env, red_, hidden);
    engine_.state->hide_prop(env, red_body_, hidden);
  }
}

TraceDemo::Place TraceDemo::place_at(int env, int elapsed) const {
  const int shown = std::max(0, elapsed - pre_demo_steps_[env]);
  const int element = std::min(shown / contours_.waypoints(), length(env) - 1);
  return {element, std::min(shown - element * contours_.waypoints(), contours_.waypoints() - 1)};
}

// Its body is placed anew as well, as in the original: it wakes nothing, and nothing at rest
// touches it.
void TraceDemo::put_red(int env, const Place& place) const {
  const Vec2 at = contour(env, place.element).waypoint(place.waypoint);
  place_upright(*engine_.state, env, red_, at, CUBE_HALFSIZE);
  if (pushes_) place_upright(*engine_.state, env, red_body_, at, CUBE_HALFSIZE);
}

void TraceDemo::put_green(int env) const {
  const double* red = engine_.state->prop_pos_of(env, red_);
  const Vec2 nominal = center(env) + Vec2(GREEN_CUBE_OFFSET_X, 0);
  const Vec2 at = pushes_ ? clear_of_red(nominal, {red[0], red[1]}) : nominal;
  place_upright(*engine_.state, env, green_, at, CUBE_HALFSIZE);
}

// The red cube has jumped to the next shape. It does not appear inside a green one that is awake.
void TraceDemo::make_room_for_red(int env) const {
  const State& state = *engine_.state;
  const double* red = state.prop_pos_of(env, red_);
  const double* green = state.prop_pos_of(env, green_);
  const double* q = state.prop_quat_of(env, green_);
  const Eigen::Matrix3d axes = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  const Eigen::Vector3d half = CUBE_HALFSIZE * axes.cwiseAbs().rowwise().sum();
  const Vec2 at = clear_of_red({green[0], green[1]}, {red[0], red[1]}, Vec2(half.x(), half.y()));
  if (at == Vec2(green[0], green[1])) return;
  const double pos[3] = {at.x(), at.y(), green[2]};
  const double quat[4] = {q[0], q[1], q[2], q[3]};
  state.place_prop(env, green_, pos, quat, PropStatus::kAwake);
}

void TraceDemo::light_lamp(int env) const {
  switch (phase(env)) {
    case TracePhase::kPreDemo:
      return lamp_.shine(*engine_.state, env, kOff);
    case TracePhase::kDemo:
      return lamp_.shine(*engine_.state, env, kRedLight);
    case TracePhase::kAction:
      return lamp_.shine(*engine_.state, env, kGreenLight);
  }
}

// --- contours ---

int TraceDemo::draw_shape(RandomStream& random) const {
  return params_.AVAILABLE_SHAPES[random.integer(0, params_.AVAILABLE_SHAPES.size() - 1)];
}

double TraceDemo::draw_radius(RandomStream& random) const {
  return random.uniform(params_.SHAPE_RADIUS_RANGE.low, params_.SHAPE_RADIUS_RANGE.high);
}

Contour TraceDemo::contour(int env, int element) const {
  // -1 in made-up snapshots alone
  return contour_as(env, element, std::max(0, shapes_.row(env)[element]));
}

Contour TraceDemo::contour_as(int env, int element, int shape) const {
  return {contours_, shape, radii_.row(env)[element], rotations_.row(env)[element], center(env)};
}

Contour TraceDemo::sample_contour(int env, RandomStream& random) const {
  const int shape = draw_shape(random);
  const double radius = draw_radius(random);
  const double rotation = draw_rotation(random);
  return {contours_, shape, radius, rotation, center(env)};
}

Vec2 TraceDemo::lamp_at(int env) const { return center(env) + Vec2(LAMP_OFFSET_X, 0); }

Vec2 TraceDemo::green_at(int env) const {
  const double* pos = engine_.state->prop_pos_of(env, green_);
  return {pos[0], pos[1]};
}

}  // namespace engram::tasks
