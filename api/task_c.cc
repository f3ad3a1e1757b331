// The C API of users' own tasks.
#include <atomic>
#include <deque>
#include <mutex>

#include "api/c_batch.h"
#include "api/c_error.h"
#include "core/base/error.h"
#include "engram/engram_task.h"
#include "protocol/custom_tasks/task_documents.h"
#include "tasks/custom/array_functions.h"
#include "tasks/custom/custom_family.h"

struct engram_task_reply {
  std::string text;
  std::string failure;
};

struct engram_task_memory {
  std::shared_ptr<void> of_all;
  std::shared_ptr<void> of_some;
  std::atomic<int> users = 1;
};

namespace {

using engram::ConstantTable;
using engram::Error;
using engram::c::call_host;
using engram::c::dtype_of;
using engram::c::guarded;
using engram::tasks::CustomArray;
using engram::tasks::CustomMethod;
using engram::tasks::RobotRows;

[[noreturn]] void refuse(const std::string& what) { throw Error(Error::kInvalidArgument, what); }

[[noreturn]] void fail(const std::string& id, const engram_task_reply& reply) {
  throw Error(
      Error::kTaskFailed,
      "task '" + id + "': " + (reply.failure.empty() ? "its rules have failed" : reply.failure));
}

// One instance of a task that consists of callbacks.
class CallbackInstance final : public engram::tasks::CustomInstance {
 public:
  CallbackInstance(const engram_task_callbacks& callbacks, void* user, const std::string& id,
                   const ConstantTable& constants)
      : callbacks_(callbacks), id_(id) {
    engram_task_reply reply;
    const std::string json = to_line(engram::Json(constants));
    if (call_host(callbacks_.create, user, id.c_str(), json.c_str(), &instance_, &reply) != 0) {
      fail(id_, reply);
    }
    try {
      description_ = engram::parse_task_description(reply.text, id);
    } catch (...) {
      call_host(callbacks_.destroy, instance_);
      throw;
    }
  }
  ~CallbackInstance() override {
    call_host(callbacks_.destroy, instance_);
    for (engram_task_memory* memory : memories_) engram_task_memory_release(memory);
  }
  CallbackInstance(const CallbackInstance&) = delete;
  CallbackInstance& operator=(const CallbackInstance&) = delete;

  const engram::tasks::CustomDescription& description() const override { return description_; }

  void bind(std::span<const CustomArray> arrays, int num_envs) override {
    std::vector<engram_task_array> plain;
    for (const CustomArray& array : arrays) {
      memories_.push_back(new engram_task_memory{array.memory_of_all, array.memory_of_some});
      const std::string& name = names_.emplace_back(array.field.name);
      plain.push_back({name.c_str(), dtype_of(array.field.dtype), array.field.width,
                       array.is_written ? 1 : 0, array.all, array.subset_rows, memories_.back()});
    }
    engram_task_reply reply;
    if (call_host(callbacks_.bind, instance_, plain.data(), plain.size(), num_envs, &reply) != 0) {
      fail(id_, reply);
    }
  }

  void call(CustomMethod method, int rows, bool of_all) override {
    engram_task_reply reply;
    if (call_host(callbacks_.call, instance_, static_cast<int32_t>(method), rows, of_all ? 1 : 0,
                  &reply) != 0) {
      fail(id_, reply);
    }
  }

 private:
  engram_task_callbacks callbacks_;
  std::string id_;
  void* instance_ = nullptr;
  engram::tasks::CustomDescription description_;
  std::vector<engram_task_memory*> memories_;
  std::deque<std::string> names_;
};

class CallbackFactory final : public engram::tasks::CustomFactory {
 public:
  CallbackFactory(const engram_task_callbacks& callbacks, void* user)
      : callbacks_(callbacks), user_(user) {}

  std::unique_ptr<engram::tasks::CustomInstance> make(
      const std::string& id, const ConstantTable& constants) const override {
    return std::make_unique<CallbackInstance>(callbacks_, user_, id, constants);
  }

 private:
  engram_task_callbacks callbacks_;
  void* user_;
};

// Throws Error unless all addresses are there and the number of rows is not negative.
void require_rows(int32_t count, std::initializer_list<const void*> arrays) {
  if (count < 0) refuse("count: " + std::to_string(count) + " given, at least 0 needed");
  for (const void* array : arrays) {
    if (array == nullptr && count > 0) refuse("array: NULL given, an address needed");
  }
}

}  // namespace

void engram_task_memory_retain(engram_task_memory* memory) { ++memory->users; }

void engram_task_memory_release(engram_task_memory* memory) {
  if (--memory->users == 0) delete memory;
}

void engram_task_describe(engram_task_reply* reply, const char* json) {
  (void)guarded([&] { reply->text = json; });
}

void engram_task_fail(engram_task_reply* reply, const char* message) {
  (void)guarded([&] { reply->failure = message; });
}

engram_status engram_register_task(const char* definition, const engram_task_callbacks* callbacks,
                                   void* user) {
  return guarded([&] {
    if (definition == nullptr) refuse("definition: NULL given, a JSON object needed");
    if (callbacks == nullptr || callbacks->struct_size != sizeof *callbacks) {
      refuse("callbacks: a struct with struct_size set to its size needed");
    }
    if (callbacks->create == nullptr || callbacks->bind == nullptr || callbacks->call == nullptr ||
        callbacks->destroy == nullptr) {
      refuse("callbacks: NULL given, create, bind, call and destroy needed");
    }
    engram::tasks::register_custom(engram::parse_definition(definition),
                                   std::make_shared<CallbackFactory>(*callbacks, user));
  });
}

engram_status engram_servo_tcp(int32_t count, const double* tcp_pos, const double* tcp_quat,
                               const double* goals, const double* orientations,
                               const double* grippers, float* actions) {
  return guarded([&] {
    require_rows(count, {tcp_pos, tcp_quat, goals, orientations, grippers, actions});
    servo_rows(count, RobotRows{.tcp_pos = tcp_pos, .tcp_quat = tcp_quat}, goals, orientations,
               grippers, actions);
  });
}

engram_status engram_approach_from_above(int32_t count, const double* tcp_pos, const double* goals,
                                         double clearance, double* waypoints) {
  return guarded([&] {
    require_rows(count, {tcp_pos, goals, waypoints});
    approach_rows(count, RobotRows{.tcp_pos = tcp_pos}, goals, clearance, waypoints);
  });
}

engram_status engram_descend(int32_t count, const double* tcp_pos, const double* goals,
                             double travel_height, double* waypoints) {
  return guarded([&] {
    require_rows(count, {tcp_pos, goals, waypoints});
    descend_rows(count, RobotRows{.tcp_pos = tcp_pos}, goals, travel_height, waypoints);
  });
}

engram_status engram_tilt_outwards(int32_t count, const double* orientations, const double* points,
                                   double reach, double per_metre, double most, double* tilted) {
  return guarded([&] {
    require_rows(count, {orientations, points, tilted});
    engram::tasks::tilt_rows(count, orientations, points,
                             {.reach = reach, .per_metre = per_metre, .most = most}, tilted);
  });
}

engram_status engram_tour(int32_t count, const double* tcp_pos, const double* qvel,
                          const int32_t* elapsed, const double* stops, int32_t num_stops,
                          double start_height, double reach, int32_t again, int32_t needs_rest,
                          double* goals, uint8_t* rests) {
  return guarded([&] {
    require_rows(count, {tcp_pos, qvel, elapsed, stops, goals, rests});
    constexpr int kMax = engram::tasks::Tour::kMaxStops;
    if (num_stops < 1 || num_stops > kMax) {
      refuse("num_stops: " + std::to_string(num_stops) + " given, 1 to " + std::to_string(kMax) +
             " allowed");
    }
    tour_rows(count, RobotRows{.qvel = qvel, .tcp_pos = tcp_pos, .elapsed = elapsed}, stops,
              num_stops,
              {.start_height = start_height,
               .reach = reach,
               .again = again != 0,
               .rests = needs_rest != 0},
              goals, rests);
  });
}

engram_status engram_is_grasping(int32_t count, const double* tcp_quat, const double* finger_force,
                                 int32_t num_props, int32_t prop, double min_force,
                                 double max_angle, uint8_t* held) {
  return guarded([&] {
    require_rows(count, {tcp_quat, finger_force, held});
    if (prop < 0 || prop >= num_props) {
      refuse("prop: " + std::to_string(prop) + " given, 0 to " + std::to_string(num_props - 1) +
             " allowed");
    }
    grasp_rows(count, RobotRows{.tcp_quat = tcp_quat}, finger_force, num_props, prop, min_force,
               max_angle, held);
  });
}

engram_status engram_guesses(int32_t count, const uint64_t* keys, const uint64_t* episodes,
                             int32_t width, double* numbers) {
  return guarded([&] {
    require_rows(count, {keys, episodes, numbers});
    if (width < 0) refuse("width: " + std::to_string(width) + " given, at least 0 needed");
    engram::tasks::guess_rows(count, keys, episodes, width, numbers);
  });
}

engram_status engram_real_function(const char* name, size_t count, const double* x, const double* y,
                                   double* values) {
  return guarded([&] {
    if (name == nullptr) refuse("name: NULL given, the name of a function needed");
    require_rows(count > 0 ? 1 : 0, {x, values});
    if (!engram::tasks::apply_real_function(name, count, x, y, values)) {
      refuse("function '" + std::string(name) +
             "' given; sin, cos, tan, exp, log, asin and tanh of x allowed, atan2 and hypot of x "
             "and y");
    }
  });
}
