#include "balance/import/spec_page.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/import/names.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::foreign {

std::string format_yaml_number(double value) { return fmt::format("{}", value + 0.0); }

std::string format_yaml_list(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + format_yaml_number(value);
  return "[" + text + "]";
}

std::string quote_yaml_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : escape_for_terminal(text))
    out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

std::string SpecWriterPage::vector(const Vector3& v) const {
  return planar() ? format_yaml_list({v.x(), v.y()}) : format_yaml_list({v.x(), v.y(), v.z()});
}

void SpecWriterPage::line(int indent, const std::string& content, const std::string& comment) {
  text += std::string(static_cast<std::size_t>(indent), ' ') + content;
  if (!comment.empty()) text += (content.empty() ? "# " : "  # ") + escape_for_terminal(comment);
  text += "\n";
}

bool SpecWriterPage::carries(int body) const {
  const auto ends = [body](const auto& one) { return one.first == body || one.second == body; };
  return std::count_if(robot.joints.begin(), robot.joints.end(),
                       [&](const ForeignJoint& one) { return one.is_active && ends(one.joint); }) > 1 ||
         std::any_of(robot.springs.begin(), robot.springs.end(), ends);
}

namespace {

class OptionalSectionWriter {
 public:
  explicit OptionalSectionWriter(SpecWriterPage& page) : page_(page) {}

  void run() {
    payloads();
    springs();
    armatures();
    friction();
    ending();
  }

 private:
  /// A body at the end of a chain has a motor but no mass: what it carries may be written here.
  void payloads() {
    bool first = true;
    for (std::size_t b = 1; b < page_.robot.bodies.size(); ++b) {
      const Body& body = page_.robot.bodies[b].body;
      if (!page_.robot.bodies[b].is_active || body.mass != 0 || !body.inertia.isZero(0) ||
          page_.carries(static_cast<int>(b)))
        continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "payloads:", "of bodies without mass at the ends of chains: nothing, so far");
      }
      first = false;
      page_.line(2, fmt::format("{}: {{body: {}, at: origin, mass: 0}}", page_.names.bodies[b], page_.names.bodies[b]));
    }
  }

  void springs() {
    const auto sprung = [](const ForeignJoint& one) { return one.is_active && one.stiffness != 0; };
    const auto& joints = page_.robot.joints;
    if (page_.robot.springs.empty() && std::none_of(joints.begin(), joints.end(), sprung)) return;
    page_.line(0, "");
    page_.line(0, "springs:");
    NameAllocator given({});
    for (std::size_t s = 0; s < page_.robot.springs.size(); ++s) {
      const Spring& one = page_.robot.springs[s];
      page_.line(2, fmt::format("{}: {{between: [{}, {}], stiffness: {}, free_length: {}}}", given.allocate(one.name),
                                page_.names.spring_ends[s].first, page_.names.spring_ends[s].second,
                                format_yaml_number(one.stiffness), format_yaml_number(one.free_length)));
    }
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (sprung(joints[j]))
        page_.line(
            2, fmt::format("{}: {{joint: {}, stiffness: {}, rest: {}}}",
                           given.allocate(page_.names.joints[j] + "_spring"), page_.names.joints[j],
                           format_yaml_number(joints[j].stiffness), format_yaml_number(joints[j].spring_reference)));
  }

  /// What only a rotor on the joint could be, to be taken in by whoever wants it.
  void armatures() {
    bool first = true;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& one = page_.robot.joints[j];
      if (!one.is_active || one.armature == 0) continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "", "The file has armatures, the inertia of geared rotors. As discs they would be:");
        page_.line(0, "", "discs:");
      }
      first = false;
      disc_for(j, one);
    }
  }

  /// On the first body it turns by q against that body; on the ground nothing can be carried, and on the second it turns twice as fast.
  void disc_for(std::size_t j, const ForeignJoint& one) {
    const Joint& joint = one.joint;
    const bool on_second = joint.first == 0 || joint.type != JointType::revolute;
    const bool doubled = on_second && joint.type == JointType::revolute;
    const double axial = doubled ? one.armature / 4 : one.armature;
    const auto carrier = static_cast<std::size_t>(on_second ? joint.second : joint.first);
    const std::string inertia = page_.planar() ? format_yaml_number(axial)
                                               : fmt::format("{{axial: {}, transverse: {}}}", format_yaml_number(axial),
                                                             format_yaml_number(axial / 2));
    page_.line(
        0, "",
        fmt::format("  {}_rotor: {{body: {}, at: {}, follows: {}, inertia: {}}}", page_.names.joints[j],
                    page_.names.bodies[carrier], page_.vector(on_second ? joint.point_second : joint.point_first),
                    page_.names.joints[j], inertia));
  }

  void friction() {
    bool first = true;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& one = page_.robot.joints[j];
      if (!one.is_active || (one.viscous == 0 && one.coulomb == 0)) continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "friction:");
      }
      first = false;
      page_.line(2, fmt::format("{}: {{viscous: {}, coulomb: {}}}", page_.names.joints[j],
                                format_yaml_number(one.viscous), format_yaml_number(one.coulomb)));
    }
  }

  void ending() {
    std::string from_values, to_values;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& one = page_.robot.joints[j];
      if (!one.is_active || !one.is_actuated || joint_degrees_of_freedom(one.joint.type) != 1) continue;
      const auto found = std::find_if(page_.assembly.begin(), page_.assembly.end(),
                                      [&](const AssemblyValue& value) { return value.first == page_.names.joints[j]; });
      const double start = found == page_.assembly.end() ? 0 : found->second;
      const char* comma = from_values.empty() ? "" : ", ";
      from_values += fmt::format("{}{}: {:.6g}", comma, page_.names.joints[j], start + 0.0);
      to_values += fmt::format("{}{}: {:.6g}", comma, page_.names.joints[j], start + 0.1);
    }
    if (from_values.empty()) return;
    page_.line(0, "");
    page_.line(0, "", "To simulate it, say from where to where, for example:");
    page_.line(0, "",
               fmt::format("motion: {{duration: 1, from: {{joints: {{{}}}}}, to: {{joints: {{{}}}}}}}", from_values,
                           to_values));
  }

  SpecWriterPage& page_;
};

}  // namespace

void write_optional_sections(SpecWriterPage& page) { OptionalSectionWriter(page).run(); }

}  // namespace balance::foreign
