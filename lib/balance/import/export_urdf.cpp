#include "balance/import/export_urdf.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/import/closures.hpp"
#include "balance/import/element_reader.hpp"
#include "balance/import/prepare.hpp"
#include "balance/import/spec_page.hpp"
#include "balance/import/urdf.hpp"
#include "balance/import/xml_document.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>

namespace balance {

namespace {

using namespace foreign;

/// Mass, first moment and inertia about a frame's origin: they add up.
struct Moments {
  double mass = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();

  void add(double m, const Vector3& com, const Matrix3& central, double sign = 1) {
    mass += sign * m;
    first += sign * m * com;
    second += sign * (central - m * skew(com) * skew(com));
  }
};

struct Edit {
  std::size_t begin, end;
  std::string text;
};

class Exporter {
 public:
  Exporter(const Study& study, const std::string& text, const std::string& file, const ImportOptions& options)
      : mechanism_(study.mechanism), spec_file_(study.spec_file), document_(parse_xml(text, file)) {
    if (document_->root.name != "robot")
      throw SpecError({.place = place_of(document_->root), .message = "expected <robot>: only a URDF can be written"});
    raw_ = read_urdf(*document_);
    if (!options.loops.empty()) read_loops(read_text_file(options.loops, "closures"), shown_name(options.loops), raw_);
    merged_ = raw_;
    prepare(merged_, options);
    names_ = spec_names(merged_);
  }

  ExportedUrdf run() {
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) write(static_cast<int>(b));
    if (!mechanism_.discs.empty()) out_.notes.push_back("discs have no place in a URDF: they are left out");
    if (!mechanism_.springs.empty()) out_.notes.push_back("springs have no place in a URDF: they are left out");
    std::sort(edits_.begin(), edits_.end(), [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
    std::size_t at = 0;
    for (const Edit& edit : edits_) {
      out_.text += document_->text.substr(at, edit.begin - at) + edit.text;
      at = edit.end;
    }
    out_.text += document_->text.substr(at);
    return std::move(out_);
  }

 private:
  /// The merged body that is called so in the spec.
  int find(const std::string& name) const {
    for (std::size_t b = 1; b < names_.bodies.size(); ++b)
      if (merged_.bodies[b].kept && names_.bodies[b] == name) return static_cast<int>(b);
    throw SpecError(
        {.place = {.file = spec_file_},
         .message = fmt::format("body {}: {} has no link that becomes it", in_quotes(name), document_->file)});
  }

  Moments wanted(int body) const {
    const Body& own = mechanism_.bodies[static_cast<std::size_t>(body)];
    Moments sum;
    sum.add(own.mass, own.com, own.inertia);
    for (const Attachment& extra : mechanism_.attachments)
      if (extra.body == body && extra.kind == AttachmentKind::counterweight)
        sum.add(extra.mass, extra.position, extra.inertia);
    return sum;
  }

  /// The links of a body with their places in it, the carrier first.
  std::vector<Member> links_of(int merged) const {
    std::vector<Member> links{{merged, {}}};
    const auto& members = merged_.bodies[static_cast<std::size_t>(merged)].members;
    links.insert(links.end(), members.begin(), members.end());
    return links;
  }

  const Body& link(int index) const { return raw_.bodies[static_cast<std::size_t>(index)].body; }

  void write(int body) {
    const std::string& name = mechanism_.bodies[static_cast<std::size_t>(body)].name;
    const int merged = find(name);
    Moments rest = wanted(body);
    const std::vector<Member> links = links_of(merged);
    if (is_unchanged(rest, merged_.bodies[static_cast<std::size_t>(merged)].body)) return;
    const auto taker = std::find_if(links.begin(), links.end(), [&](const Member& one) {
      return raw_.bodies[static_cast<std::size_t>(one.body)].inertial;
    });
    if (taker == links.end())
      throw SpecError({.place = merged_.bodies[static_cast<std::size_t>(merged)].place,
                       .message = fmt::format("link {}: has no <inertial> that could take a mass of {:.6g} kg",
                                              in_quotes(link(merged).name), rest.mass)});
    for (const Member& one : links)
      if (one.body != taker->body) {
        const Body& other = link(one.body);
        rest.add(other.mass, one.pose.p + one.pose.R * other.com, one.pose.R * other.inertia * one.pose.R.transpose(),
                 -1);
      }
    write_link(taker->body, taker->pose, rest);
  }

  /// To the last digits: then the file's own numbers stay.
  static bool is_unchanged(const Moments& wanted, const Body& body) {
    Moments before;
    before.add(body.mass, body.com, body.inertia);
    const double near = 1e-14;
    return std::abs(wanted.mass - before.mass) <= near * std::abs(before.mass) &&
           (wanted.first - before.first).norm() <= near * before.first.norm() &&
           (wanted.second - before.second).norm() <= near * before.second.norm();
  }

  const XmlElement* find_link(const std::string& name) const {
    for (const XmlElement& part : document_->root.children)
      if (part.name == "link" && part.attribute("name") != nullptr && *part.attribute("name") == name) return &part;
    return nullptr;
  }

  void write_link(int index, const Pose& pose, const Moments& total) {
    const XmlElement& inertial = *find_link(link(index).name)->child("inertial");
    if (!(total.mass > 0))
      throw SpecError(
          {.place = place_of(inertial),
           .message = fmt::format("link {}: {:.6g} kg would be left for it", in_quotes(link(index).name), total.mass)});
    const Vector3 com = total.first / total.mass;
    const Matrix3 central = total.second + total.mass * skew(com) * skew(com);
    const XmlElement* origin = inertial.child("origin");
    Matrix3 axes = Matrix3::Identity();
    if (origin != nullptr && origin->attribute("rpy") != nullptr) {
      const auto v = numbers_of(*origin, "rpy");
      axes = rotation_from_rpy({v[0], v[1], v[2]});
    }
    const Matrix3 R = (pose.R * axes).transpose();  // from the body's axes to those of the inertia
    const Matrix3 I = R * central * R.transpose();
    const Vector3 place = pose.R.transpose() * (com - pose.p);
    set(*inertial.child("mass"), "value", {total.mass});
    set_origin(inertial, origin, place);
    if (const XmlElement* inertia = inertial.child("inertia"))
      for (const auto& [key, i, j] :
           {std::tuple{"ixx", 0, 0}, {"ixy", 0, 1}, {"ixz", 0, 2}, {"iyy", 1, 1}, {"iyz", 1, 2}, {"izz", 2, 2}})
        set(*inertia, key, {I(i, j)});
    out_.changed.push_back(link(index).name);
  }

  /// The reader has checked that they are numbers.
  static std::vector<double> numbers_of(const XmlElement& at, const char* attribute) {
    return numbers_in(*at.attribute(attribute)).value_or(std::vector<double>{});
  }

  void set_origin(const XmlElement& inertial, const XmlElement* origin, const Vector3& place) {
    if (origin != nullptr && origin->attribute("xyz") != nullptr)
      return set(*origin, "xyz", {place.x(), place.y(), place.z()});
    if (place.isZero(0)) return;
    const std::string xyz = fmt::format("xyz=\"{} {} {}\"", number(place.x()), number(place.y()), number(place.z()));
    if (origin != nullptr)
      edits_.push_back({origin->offset + origin->name.size(), origin->offset + origin->name.size(), " " + xyz});
    else
      edits_.push_back(
          {inertial.child("mass")->offset - 1, inertial.child("mass")->offset - 1, "<origin " + xyz + "/>"});
  }

  /// Numbers that are what stands there stay as they are written.
  void set(const XmlElement& at, const char* attribute, const std::vector<double>& values) {
    const auto before = at.attribute(attribute) == nullptr ? std::vector<double>{} : numbers_of(at, attribute);
    if (before == values) return;
    std::string text;
    for (const double value : values) text += (text.empty() ? "" : " ") + number(value);
    const XmlSpan span = value_span(at, attribute);
    if (span.end > span.begin)
      edits_.push_back({span.begin, span.end, text});
    else if (values != std::vector<double>{0})
      edits_.push_back(
          {at.offset + at.name.size(), at.offset + at.name.size(), fmt::format(" {}=\"{}\"", attribute, text)});
  }

  const Mechanism& mechanism_;
  std::string spec_file_;
  std::unique_ptr<const XmlDocument> document_;
  Robot raw_, merged_;
  SpecNames names_;
  std::vector<Edit> edits_;
  ExportedUrdf out_;
};

}  // namespace

ExportedUrdf export_urdf(const Study& study, const std::string& text, const std::string& file,
                         const ImportOptions& options) {
  return Exporter(study, text, file, options).run();
}

std::string parts_csv(const Mechanism& mechanism) {
  std::string text = "name,kind,body,x,y,z,mass,ixx,iyy,izz,ixy,ixz,iyz\n";
  const auto add = [&](const std::string& name, const char* kind, int body, const Vector3& p, double mass,
                       const Matrix3& I) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", name, kind,
                        mechanism.bodies[static_cast<std::size_t>(body)].name, number(p.x()), number(p.y()),
                        number(p.z()), number(mass), number(I(0, 0)), number(I(1, 1)), number(I(2, 2)), number(I(0, 1)),
                        number(I(0, 2)), number(I(1, 2)));
  };
  for (const Attachment& one : mechanism.attachments)
    if (one.kind == AttachmentKind::counterweight)
      add(one.name, "counterweight", one.body, one.position, one.mass, one.inertia);
  for (const Disc& one : mechanism.discs) add(one.name, "disc", one.body, one.position, one.mass, one.inertia);
  return text;
}

}  // namespace balance
