#pragma once
/// What bodies, joints and points of a robot are called in its spec. Private to the writer of specs.

#include "balance/import/robot.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

struct GeneratedNames {
  std::vector<std::string> bodies, joints;                ///< by index in the robot
  std::vector<std::vector<NamedPoint>> points;            ///< of every body: ends of joints and springs, then frames
  std::vector<std::pair<std::string, std::string>> ends;  ///< `body.point` of every joint on both sides
  std::vector<std::pair<std::string, std::string>> spring_ends;  ///< the same of springs
  std::vector<std::pair<std::string, std::string>> renamed;      ///< `joint 'a b'` and its new name
};

GeneratedNames spec_names(const ForeignModel& robot);

}  // namespace balance::foreign
