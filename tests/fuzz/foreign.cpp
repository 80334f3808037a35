#include "targets.hpp"

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/model_simplification.hpp"
#include "balance/interface/import/spec_writer.hpp"
#include "balance/interface/specification/read_spec.hpp"

namespace balance::fuzz {

namespace {

/// What an import does, but for closing the loops.
void make_spec(foreign::ForeignModel& robot) {
  foreign::simplify_model(robot, {.fixed_base = true});
  for (const foreign::Finding& one : robot.findings) demand(!one.text().empty(), "a finding that says nothing");
  const std::string text = foreign::generate_spec(robot, {}).text;
  // the file's numbers may be none that a spec can have; that its language is right is what matters
  complains_well([&] { read_spec(text, "s.yaml"); });
}

void import_as(std::string_view bytes, const char* file) {
  complains_well([&] {
    try {
      foreign::ForeignModel robot = foreign::read_foreign_model(std::string(bytes), file);
      make_spec(robot);
    } catch (const SystemError&) {
      // an included file that is not there
    }
  });
}

constexpr const char* four_links = R"(<robot name="r">
<link name="base"/><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="tip"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/></joint>
<joint name="j2" type="revolute"><parent link="base"/><child link="b"/></joint>
<joint name="j3" type="revolute"><parent link="a"/><child link="tip"/></joint>
</robot>)";

}  // namespace

void urdf(std::string_view bytes) { import_as(bytes, "s.urdf"); }
void mjcf(std::string_view bytes) { import_as(bytes, "s.xml"); }
void mbse(std::string_view bytes) { import_as(bytes, "s.yaml"); }
void chrono(std::string_view bytes) { import_as(bytes, "s.yaml"); }

void loops(std::string_view bytes) {
  complains_well([&] {
    foreign::ForeignModel robot = foreign::read_foreign_model(four_links, "s.urdf");
    foreign::read_gepetto_loops(std::string(bytes), "loops.yaml", robot);
    make_spec(robot);
  });
}

}  // namespace balance::fuzz
