#include "tasks/trace_shape/demo.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

namespace engram::tasks {
namespace {

constexpr double kCenterX[2] = {-0.15, -0.05};  // m: SHAPE_CENTER_X_RANGE
constexpr double kCenterY[2] = {-0.10, 0.10};   // m: SHAPE_CENTER_Y_RANGE
constexpr double kTurn = 2 * std::numbers::pi;
constexpr int STEPS_PER_WAYPOINT = 1;
constexpr double CUBE_HALFSIZE = TraceDemo::CUBE_HALFSIZE;
constexpr double HEIGHT_OFFSET = 1000.0;  // m: reported height of what is hidden

constexpr mjcf::Rgba kRed = {220 / 255.0, 50 / 255.0, 50 / 255.0, 1};
constexpr mjcf::Rgba kGreen = {50 / 255.0, 220 / 255.0, 50 / 255.0, 1};
constexpr LampLight kOff = {{245 / 255.0, 245 / 255.0, 245 / 255.0, 1}, 0};
constexpr LampLight kRedLight = {{1, 0, 0, 1}, 20};
constexpr LampLight kGreenLight = {{0, 1, 0, 1}, 20};

// In the order of TraceDemo::draws.
enum TraceDraw { kShapes, kRadii, kCenterXDraw, kCenterYDraw, kRotations, kPreDemo, kLength };

enum TraceOption { kRedPushesGreen };

// Half the side in pictures, m: where it is inside the green cube, its faces are in front.
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

// Meanings of pinned values, or values of the draw's stream.
template <class Meaning, class Sample, class T>
void draw_values(const Episode& episode, int draw, T* values, int count, Meaning meaning,
                 Sample sample) {
  if (const double* pinned = episode.pinned(draw)) {
    std::transform(pinned, pinned + count, values, meaning);
    return;
  }
  RandomStream random = episode.stream(draw);
  std::generate_n(values, count, [&] { return sample(random); });
}

// "0 circle, 1 square".
std::string in_words(const NameList& shapes) {
  std::string words;
  for (int i = 0; i < shapes.size(); ++i) {
    words += (i == 0 ? "" : ", ") + std::to_string(i) + " " +
             kContourNames[static_cast<std::size_t>(shapes[i])];
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

TraceDemo::TraceDemo(mjcf::Scene& scene, const TraceParams& params)
    : params_(params),
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

std::vector<RandomVariable> TraceDemo::draws() const {
  const int most = params_.MAX_SEQUENCE_LENGTH;
  const bool one = !params_.sequence;
  const auto [shortest, longest] = params_.SHAPE_RADIUS_RANGE;
  std::vector<RandomVariable> draws = {
      {one ? "shape" : "shapes", most, true, 0, params_.AVAILABLE_SHAPES.size() - 1.0, "",
       in_words(params_.AVAILABLE_SHAPES)},
      {one ? "radius" : "radii", most, false, shortest, longest, "m", "", false,
       "SHAPE_RADIUS_RANGE"},
      {"center_x", 1, false, kCenterX[0], kCenterX[1], "m", "of every shape"},
      {"center_y", 1, false, kCenterY[0], kCenterY[1], "m", "of every shape"},
      {one ? "rotation" : "rotations", most, false, 0, kTurn, "rad", ""},
      PRE_DEMO_STEPS.draw("pre_demo_steps", "before the demonstration"),
  };
  if (!one) {
    draws.push_back({"sequence_length", 1, true, static_cast<double>(params_.MIN_SEQUENCE_LENGTH),
                     static_cast<double>(most), "", "how many of the shapes are shown"});
  }
  return draws;
}

std::vector<TaskOptionSpec> TraceDemo::options() {
  return {{"red_pushes_green", 0, true, 0, 1, "",
           "1: the red cube pushes the green one, whose place then tells of the shapes", 1}};
}

ConstantTable TraceDemo::constants() const {
  ConstantList shapes;
  for (int i = 0; i < params_.AVAILABLE_SHAPES.size(); ++i) {
    shapes.emplace_back(params_.AVAILABLE_SHAPES[i]);
  }
  const auto [shortest, longest] = params_.SHAPE_RADIUS_RANGE;
  return {
      {"AVAILABLE_SHAPES", shapes},
      {"SHAPE_CIRCLE", SHAPE_CIRCLE},
      {"SHAPE_SQUARE", SHAPE_SQUARE},
      {"SHAPE_TRIANGLE", SHAPE_TRIANGLE},
      {"NUM_WAYPOINTS", params_.contours.NUM_WAYPOINTS},
      {"NUM_CHECKPOINTS", params_.contours.NUM_CHECKPOINTS},
      {"CHECKPOINT_THRESH", params_.contours.CHECKPOINT_THRESH},
      {"PRE_DEMO_STEPS", PRE_DEMO_STEPS.constant()},
      {"STEPS_PER_WAYPOINT", STEPS_PER_WAYPOINT},
      {"CUBE_HALFSIZE", CUBE_HALFSIZE},
      {"SHAPE_RADIUS_RANGE", ConstantList{shortest, longest}},
      {"SHAPE_CENTER_X_RANGE", ConstantList{kCenterX[0], kCenterX[1]}},
      {"SHAPE_CENTER_Y_RANGE", ConstantList{kCenterY[0], kCenterY[1]}},
      {"GREEN_CUBE_OFFSET_X", GREEN_CUBE_OFFSET_X},
      {"LAMP_OFFSET_X", LAMP_OFFSET_X},
      {"HEIGHT_OFFSET", HEIGHT_OFFSET},
  };
}

void TraceDemo::bind(const Bindings& bindings) {
  engine_ = bindings;
  pushes_ = bindings.options[kRedPushesGreen] != 0;
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
      episode, kShapes, shapes_.row(env), most,
      [this](double pinned) { return params_.AVAILABLE_SHAPES[static_cast<int>(pinned)]; },
      [this](RandomStream& random) { return draw_shape(random); });
  auto range = params_.SHAPE_RADIUS_RANGE;
  episode.narrow(kRadii, range[0], range[1]);
  draw_values(episode, kRadii, radii_.row(env), most, std::identity(),
              [&](RandomStream& random) { return random.uniform(range[0], range[1]); });
  draw_values(episode, kRotations, rotations_.row(env), most, std::identity(), draw_rotation);
  center_.row(env)[0] = episode.real(kCenterXDraw, kCenterX[0], kCenterX[1]);
  center_.row(env)[1] = episode.real(kCenterYDraw, kCenterY[0], kCenterY[1]);
  pre_demo_steps_[env] = PRE_DEMO_STEPS.sample(episode, kPreDemo);
  length_[env] = params_.sequence ? episode.integer(kLength, params_.MIN_SEQUENCE_LENGTH, most) : 1;
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

// The red cube moves evenly, except for the jump from one shape to the next.
void TraceDemo::before_physics(int env) const {
  if (!pushes_) return;
  const int next = engine_.state->elapsed[env] + 1;
  if (next <= pre_demo_steps_[env] || next >= demo_end(env)) return;
  const Place to = place_at(env, next);
  if (to.waypoint == 0) return;
  const Vec2 at = contour(env, to.element).waypoint(to.waypoint);
  const double pos[3] = {at.x(), at.y(), CUBE_HALFSIZE};
  engine_.state->move_kinematic(env, red_body_, pos);
}

void TraceDemo::advance(int env) const {
  const int elapsed = engine_.state->elapsed[env];
  const int end = demo_end(env);
  light_lamp(env);
  if (elapsed < end) {
    const Place place = place_at(env, elapsed);
    put_red(env, place);
    if (pushes_ && place.element > 0 && place.waypoint == 0) make_room_for_red(env);
  } else if (elapsed == end) {
    const double* last = engine_.state->prop_pos_of(env, red_);
    const double hidden[3] = {last[0], last[1], CUBE_HALFSIZE + HEIGHT_OFFSET};
    engine_.state->hide_prop(env, red_, hidden);
    engine_.state->hide_prop(env, red_body_, hidden);
  }
}

TraceDemo::Place TraceDemo::place_at(int env, int elapsed) const {
  const int shown = std::max(0, elapsed - pre_demo_steps_[env]);
  const int element = std::min(shown / contours_.waypoints(), length(env) - 1);
  return {element, std::min(shown - element * contours_.waypoints(), contours_.waypoints() - 1)};
}

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

// The red cube has jumped to the next shape. It does not appear inside the green one.
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
  return random.uniform(params_.SHAPE_RADIUS_RANGE[0], params_.SHAPE_RADIUS_RANGE[1]);
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
