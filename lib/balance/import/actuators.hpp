#pragma once
/// Which joints have motors.

#include "balance/import/robot.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

/// Sets `driven`: of the joints that are named; if none is, of those that the file names; if it names none either and there are no
/// loops, of all that nothing else determines. Loops without motors are told.
/// @param wanted names of the file's joints
/// @throws SpecError whose file is `--actuate`
void choose_actuators(ForeignModel& robot, const std::vector<std::string>& wanted);

}  // namespace balance::foreign
