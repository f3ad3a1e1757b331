#include "tasks/registry.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "tasks/batteries_checker/checker.h"
#include "tasks/blink_count/task.h"
#include "tasks/colors/task.h"
#include "tasks/gather_and_recall/task.h"
#include "tasks/intercept/deflect.h"
#include "tasks/intercept/grab.h"
#include "tasks/remember/find_imposter.h"
#include "tasks/remember/find_same.h"
#include "tasks/rotate/task.h"
#include "tasks/shell_game/color_lamp.h"
#include "tasks/shell_game/pick.h"
#include "tasks/shell_game/push.h"
#include "tasks/shell_game/shuffle.h"
#include "tasks/shell_game/touch.h"
#include "tasks/take_it_back/task.h"
#include "tasks/timed_transfer/task.h"
#include "tasks/trace_shape/sequence.h"
#include "tasks/trace_shape/single.h"

namespace engram {
namespace {

struct Family {
  std::string_view name;
  std::unique_ptr<Task> (*make)(const RegistryEntry& entry);
};

// The families of this version. A new one is one line here and one file pair in this folder.
constexpr std::array kFamilies = {
    Family{"RememberColor", tasks::make_remember},
    Family{"RememberShape", tasks::make_remember},
    Family{"RememberShapeAndColor", tasks::make_remember},
    Family{"FindImposterColor", tasks::make_find_imposter},
    Family{"FindImposterShape", tasks::make_find_imposter},
    Family{"FindImposterShapeAndColor", tasks::make_find_imposter},
    Family{"ShellGameTouch", tasks::make_shell_game_touch},
    Family{"ShellGamePush", tasks::make_shell_game_push},
    Family{"ShellGamePick", tasks::make_shell_game_pick},
    Family{"ShellGameColorLampTouch", tasks::make_shell_game_color_lamp},
    Family{"ShellGameShuffleTouch", tasks::make_shell_game_shuffle_touch},
    Family{"ShellGameShuffleColorLampTouch", tasks::make_shell_game_shuffle_color_lamp},
    Family{"BunchOfColors", tasks::make_color_recall},
    Family{"SeqOfColors", tasks::make_color_recall},
    Family{"ChainOfColors", tasks::make_color_recall},
    Family{"BlinkCountButtonPress", tasks::make_blink_count},
    Family{"Intercept", tasks::make_intercept},
    Family{"InterceptGrab", tasks::make_intercept_grab},
    Family{"RotateLenient", tasks::make_rotate},
    Family{"RotateStrict", tasks::make_rotate},
    Family{"TakeItBack", tasks::make_take_it_back},
    Family{"TraceShape", tasks::make_trace_shape},
    Family{"TraceShapeSeq", tasks::make_trace_shape_seq},
    Family{"TimedTransfer", tasks::make_timed_transfer},
    Family{"GatherAndRecall", tasks::make_gather_and_recall},
    Family{"BatteriesCheckerEasy", tasks::make_battery_checker},
    Family{"BatteriesCheckerHard", tasks::make_battery_checker},
};

const Family* find_family(std::string_view name) {
  const auto* found = std::find_if(kFamilies.begin(), kFamilies.end(),
                                   [name](const Family& family) { return family.name == name; });
  return found == kFamilies.end() ? nullptr : found;
}

}  // namespace

const RegistryEntry& require_entry(std::string_view id) {
  if (const RegistryEntry* entry = find_entry(id)) return *entry;
  throw Error(Error::kUnknownId, "no task '" + std::string(id) + "'; did you mean '" +
                                     nearest_id(id) + "'? `engram list` shows all");
}

std::unique_ptr<Task> make_task(std::string_view id) {
  const RegistryEntry& entry = require_entry(id);
  const Family* family = find_family(entry.family);
  if (family == nullptr) {
    throw Error(Error::kInternal, "task '" + std::string(id) + "' is registered, but its family " +
                                      std::string(entry.family) + " is not in kFamilies");
  }
  return family->make(entry);
}

}  // namespace engram
