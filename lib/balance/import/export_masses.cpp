#include "balance/import/export_masses.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/import/closures.hpp"
#include "balance/import/mass_file.hpp"
#include "balance/import/prepare.hpp"
#include "balance/import/spec_page.hpp"
#include "balance/spec/text_file.hpp"
#include "balance/study/passing_payloads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace balance {

namespace {

using namespace foreign;

/// Mass, first moment and inertia about a frame's origin: they add up.
struct MassMoments {
  double mass = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();

  void add(double m, const Vector3& com, const Matrix3& central, double sign = 1) {
    mass += sign * m;
    first += sign * m * com;
    second += sign * (central - m * skew(com) * skew(com));
  }
};

std::unique_ptr<MassPropertyWriter> open_mass_writer(const XmlDocument& document) {
  if (document.root.name == "robot") return make_urdf_mass_writer(document);
  if (document.root.name == "mujoco") return make_mjcf_mass_writer(document);
  throw SpecError({.place = place_of(document.root),
                   .message = "expected <robot> or <mujoco>: only a URDF or an MJCF can be written"});
}

class MassExporter {
 public:
  MassExporter(const Study& study, const std::string& text, const std::string& file, const ImportOptions& options)
      : mechanism_(study.mechanism), spec_file_(study.spec_file), document_(parse_xml(text, file)) {
    file_ = open_mass_writer(*document_);
    raw_ = file_->read();
    if (!options.loops.empty())
      read_gepetto_loops(read_text_file(options.loops, "closures"), display_name(options.loops), raw_);
    merged_ = raw_;
    simplify_model(merged_, options);
    names_ = spec_names(merged_);
  }

  MassExport run() {
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) write(static_cast<int>(b));
    const std::string place = fmt::format("have no place in this {}: they are left out", file_->name());
    if (!mechanism_.discs.empty()) out_.notes.push_back("discs " + place);
    if (!mechanism_.springs.empty()) out_.notes.push_back("springs " + place);
    out_.text = edits_.apply(document_->text);
    return std::move(out_);
  }

 private:
  /// The merged body that is called so in the spec.
  int find(const std::string& name) const {
    for (std::size_t b = 1; b < names_.bodies.size(); ++b)
      if (merged_.bodies[b].is_active && names_.bodies[b] == name) return static_cast<int>(b);
    throw SpecError({.place = {.file = spec_file_},
                     .message = fmt::format("body {}: {} has no {} that becomes it", quote_for_message(name),
                                            document_->file, file_->body_term())});
  }

  MassMoments wanted(int body) const {
    const Body& own = mechanism_.bodies[static_cast<std::size_t>(body)];
    MassMoments sum;
    sum.add(own.mass, own.com, own.inertia);
    for (const Attachment& extra : mechanism_.attachments)
      if (extra.body == body && extra.kind == AttachmentKind::counterweight)
        sum.add(extra.mass, extra.position, extra.inertia);
    return sum;
  }

  /// The links of a body with their places in it, the carrier first.
  std::vector<MergedBody> links_of(int merged) const {
    std::vector<MergedBody> links{{merged, {}}};
    const auto& members = merged_.bodies[static_cast<std::size_t>(merged)].merged_bodies;
    links.insert(links.end(), members.begin(), members.end());
    return links;
  }

  const Body& link(int index) const { return raw_.bodies[static_cast<std::size_t>(index)].body; }
  const ForeignBody& raw(const MergedBody& member) const { return raw_.bodies[static_cast<std::size_t>(member.body)]; }

  void write(int body) {
    const std::string& name = mechanism_.bodies[static_cast<std::size_t>(body)].name;
    const int merged = find(name);
    MassMoments rest = wanted(body);
    const std::vector<MergedBody> links = links_of(merged);
    if (is_unchanged(rest, merged_.bodies[static_cast<std::size_t>(merged)].body)) return;
    auto taker = std::find_if(links.begin(), links.end(), [&](const MergedBody& one) {
      return raw(one).has_inertial && file_->can_set_mass(raw(one));
    });
    if (taker == links.end())
      taker = std::find_if(links.begin(), links.end(),
                           [&](const MergedBody& one) { return file_->can_set_mass(raw(one)); });
    if (taker == links.end())
      throw SpecError({.place = merged_.bodies[static_cast<std::size_t>(merged)].place,
                       .message = fmt::format("{} {}: has no <inertial> that could take a mass of {:.6g} kg",
                                              file_->body_term(), quote_for_message(link(merged).name), rest.mass)});
    for (const MergedBody& one : links)
      if (one.body != taker->body) {
        const Body& other = link(one.body);
        rest.add(other.mass, one.pose.p + one.pose.R * other.com, one.pose.R * other.inertia * one.pose.R.transpose(),
                 -1);
      }
    write_link(raw(*taker), taker->pose, rest);
  }

  /// To the last digits: then the file's own numbers stay.
  static bool is_unchanged(const MassMoments& wanted, const Body& body) {
    MassMoments before;
    before.add(body.mass, body.com, body.inertia);
    const double near = 1e-14;
    return std::abs(wanted.mass - before.mass) <= near * std::abs(before.mass) &&
           (wanted.first - before.first).norm() <= near * before.first.norm() &&
           (wanted.second - before.second).norm() <= near * before.second.norm();
  }

  /// @param pose of the link in the body
  void write_link(const ForeignBody& link, const Pose& pose, const MassMoments& total) {
    if (!(total.mass > 0))
      throw SpecError({.place = link.place,
                       .message = fmt::format("{} {}: {:.6g} kg would be left for it", file_->body_term(),
                                              quote_for_message(link.body.name), total.mass)});
    const Vector3 com = total.first / total.mass;
    const Matrix3 central = total.second + total.mass * skew(com) * skew(com);
    file_->write(link, {total.mass, pose.R.transpose() * (com - pose.p), pose.R.transpose() * central * pose.R},
                 edits_);
    out_.changed.push_back(link.body.name);
  }

  const Mechanism& mechanism_;
  std::string spec_file_;
  std::unique_ptr<const XmlDocument> document_;
  std::unique_ptr<MassPropertyWriter> file_;
  ForeignModel raw_, merged_;
  GeneratedNames names_;
  XmlEdits edits_;
  MassExport out_;
};

}  // namespace

MassExport export_masses(const Study& study, const std::string& text, const std::string& file,
                         const ImportOptions& options) {
  reject_temporary_payloads(study, "the masses of another file");
  return MassExporter(study, text, file, options).run();
}

std::string format_balancing_elements_csv(const Mechanism& mechanism) {
  std::string text = "name,kind,body,x,y,z,mass,ixx,iyy,izz,ixy,ixz,iyz\n";
  const auto add = [&](const std::string& name, const char* kind, int body, const Vector3& p, double mass,
                       const Matrix3& I) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", name, kind,
                        mechanism.bodies[static_cast<std::size_t>(body)].name, format_yaml_number(p.x()),
                        format_yaml_number(p.y()), format_yaml_number(p.z()), format_yaml_number(mass),
                        format_yaml_number(I(0, 0)), format_yaml_number(I(1, 1)), format_yaml_number(I(2, 2)),
                        format_yaml_number(I(0, 1)), format_yaml_number(I(0, 2)), format_yaml_number(I(1, 2)));
  };
  for (const Attachment& one : mechanism.attachments)
    if (one.kind == AttachmentKind::counterweight)
      add(one.name, "counterweight", one.body, one.position, one.mass, one.inertia);
  for (const Disc& one : mechanism.discs) add(one.name, "disc", one.body, one.position, one.mass, one.inertia);
  return text;
}

}  // namespace balance
