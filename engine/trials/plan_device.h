#pragma once

// The object `device` of a plan: the settings of run_setting.h that have a key there.

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/session/run_setting.h"
#include "geometry/base/result.h"

namespace palpate {

// Reads the object and checks it with make_setup(). The keys sensors (2), rate_Hz,
// stiffness_N_per_m, damping_Ns_per_m, and actuators or actuated_axes are required: a plan states
// them, whatever the defaults of `run` are. The force mode and A4 are not settings here, because
// they are conditions of a trial. element: the JSON path of the object.
Result<RunSettings> read_plan_device(const nlohmann::json& device, const std::string& element,
                                     RunSettingTable table = run_settings());

// The object that read_plan_device() reads as these settings. The force mode, A4, the moves and the
// measuring of effects are not in it. Requires two sensors.
nlohmann::ordered_json plan_device_json(RunSettings settings,
                                        RunSettingTable table = run_settings());

// The error of make_setup(), check_setup() or check_plant() as an error of the plan: its element
// and the fields in its texts are replaced by keys of the plan. element: the JSON path of the
// object `device`.
Error as_plan_error(Error error, const std::string& element);

// The error with each `Struct::field` of settings in it replaced by keys of the plan.
Error with_plan_keys(Error error);

}  // namespace palpate
