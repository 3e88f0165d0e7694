// The settings of the scene file's sections time, output and solver.
#pragma once

#include "scene/setting.hpp"

namespace unibody {

const SettingList<TimeSettings>& time_settings();
const SettingList<OutputSettings>& output_settings();
const SettingList<SolverSettings>& solver_settings();

// What is expected of warm_start at position level.
inline constexpr const char* position_shares = "auto or a number in [0, 0.5]: a full warm start at position level is unstable";

// All of them as a table in Markdown, for -settings.
std::string settings_table();

}  // namespace unibody
