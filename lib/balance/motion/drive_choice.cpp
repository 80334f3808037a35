#include "balance/motion/drive_choice.hpp"

#include "balance/motion/plan.hpp"

namespace balance {

template <class S>
DriveChoice<S> choose_drive(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                            int freedoms) {
  DriveChoice<S> choice;
  choice.quantities = choose_quantities(mechanism, trajectory, freedoms);
  Drive<S>& drive = choice.drive;
  attach_tool(mechanism, tree, drive);
  drive.point = choice.quantities.point;
  drive.com = choice.quantities.com;
  drive.rotation = choice.quantities.rotation;
  if constexpr (std::is_same_v<S, Planar>)
    if (choice.quantities.tool_angle) drive.linear.push_back(tool_angle(tree, drive.tool));
  for (const int coordinate : choice.quantities.coordinates)
    drive.linear.push_back(coordinate_row(mechanism, tree, coordinate));
  return choice;
}

template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&, int);
template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&, int);

}  // namespace balance
