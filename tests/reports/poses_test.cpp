#include "balance/interface/reports/gnuplot_script.hpp"
#include "balance/interface/reports/mechanism_drawing.hpp"
#include "balance/interface/reports/plot.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

using namespace balance;
using namespace balance::reports;

namespace {

struct Run {
  Mechanism mechanism;
  RunResult result;
};

Run run_of(const std::string& spec, long samples = 41) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + spec);
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = samples;
  return {study.mechanism, simulate(study.mechanism, trajectory)};
}

PlotPoint centroid(const std::vector<PlotPoint>& points) {
  PlotPoint sum;
  for (const PlotPoint& p : points) sum.x += p.x, sum.y += p.y;
  const auto count = static_cast<double>(points.size());
  return {sum.x / count, sum.y / count};
}

double distance(const PlotPoint& a, const PlotPoint& b) { return std::hypot(a.x - b.x, a.y - b.y); }

std::vector<Outline> select(const std::vector<Outline>& outlines, DrawingPart part) {
  std::vector<Outline> selected;
  std::copy_if(outlines.begin(), outlines.end(), std::back_inserter(selected),
               [&](const Outline& one) { return one.part == part; });
  return selected;
}

DrawingScale scale_of(const Run& run, const Projection& projection) {
  return drawing_scale({&run.mechanism}, {&run.result}, projection);
}

/// The two numbers in "set xrange [a:b]" of every panel.
std::vector<AxisRange> ranges_in(const std::string& script, const std::string& command) {
  std::vector<AxisRange> ranges;
  for (std::size_t at = script.find(command); at != std::string::npos; at = script.find(command, at + 1)) {
    AxisRange range;
    REQUIRE(std::sscanf(script.c_str() + at + command.size(), " [%lf:%lf]", &range.low, &range.high) == 2);
    ranges.push_back(range);
  }
  return ranges;
}

}  // namespace

TEST_CASE("drawn links keep their lengths, and drawn joints join them") {
  const Run run = run_of("3rrr.yaml");
  const Projection plane = projection_by_name("xy");
  const DrawingScale scale = scale_of(run, plane);
  for (const Eigen::Index row : {0, 13, 40}) {
    const std::vector<Outline> outlines = draw_pose(run.mechanism, run.result, row, plane, scale);
    const std::vector<Outline> links = select(outlines, DrawingPart::link);
    REQUIRE(links.size() == 7);  // six links and the platform
    int bars = 0;
    for (const Outline& link : links) {
      bars += static_cast<int>(!link.is_closed);
      // the length of P3, Table 1, to the round-off of the coordinates; a platform's side
      CHECK(distance(link.points[0], link.points[1]) == doctest::Approx(link.is_closed ? 0.15 : 0.18).epsilon(1e-12));
    }
    CHECK(bars == 6);
    const std::vector<Outline> joints = select(outlines, DrawingPart::joint);
    REQUIRE(joints.size() == 9);
    for (const Outline& joint : joints) {
      const PlotPoint centre = centroid(joint.points);
      int ends = 0;
      // closure equations are solved to 1e-12 of the characteristic length
      for (const Outline& link : links)
        for (const PlotPoint& end : link.points) ends += static_cast<int>(distance(end, centre) < 1e-10);
      const bool is_grounded = std::abs(centre.y + 0.125) < 1e-12 || std::abs(centre.y - 0.25) < 1e-12;
      CHECK(ends == (is_grounded ? 1 : 2));
    }
  }
  CHECK(select(draw_ground(run.mechanism, run.result, plane, scale), DrawingPart::ground).size() > 3);
}

TEST_CASE("the drawn tool is where the run has it, in every projection") {
  for (const char* spec : {"5r.yaml", "spatial-rrr.yaml", "stewart.yaml", "delta.yaml"}) {
    CAPTURE(spec);
    const Run run = run_of(spec, 11);
    for (const std::string& name : list_projections()) {
      const Projection projection = projection_by_name(name);
      CHECK(projection.right.dot(projection.up) == doctest::Approx(0));
      CHECK(projection.towards_viewer().norm() == doctest::Approx(1));
      if (projection.is_spatial && run.result.axes == 2) continue;
      const DrawingScale scale = scale_of(run, projection);
      for (const Eigen::Index row : {0, 7, 10}) {
        Vector3 place = Vector3::Zero();
        place.head(run.result.axes) = run.result.tool_position.row(row).transpose();
        const std::vector<Outline> marks =
            select(draw_pose(run.mechanism, run.result, row, projection, scale), DrawingPart::tool);
        REQUIRE_FALSE(marks.empty());
        CHECK(distance(centroid(marks.back().points), projection.apply(place)) < 1e-9);
      }
    }
  }
  const Vector3 z = projection_by_name("isometric").towards_viewer();
  CHECK((z - Vector3::Ones() / std::sqrt(3.0)).norm() < 1e-15);
  CHECK_THROWS_AS(projection_by_name("zx"), std::invalid_argument);
}

TEST_CASE("poses are evenly spaced in time, and the legend has their times") {
  const Run run = run_of("3rrr.yaml");
  const auto labels = [&](int poses) {
    std::vector<std::string> list;
    const Plot picture = plot_paths({{"run", &run.result, &run.mechanism}}, {.poses = poses});
    for (const PlotShape& shape : picture.panels[0].shapes)
      if (!shape.label.empty()) list.push_back(shape.label);
    return list;
  };
  CHECK(labels(1) == std::vector<std::string>{"start, t = 0 s"});
  CHECK(labels(2) == std::vector<std::string>{"start, t = 0 s", "end, t = 0.1 s"});
  CHECK(labels(3) == std::vector<std::string>{"start, t = 0 s", "t = 0.05 s", "end, t = 0.1 s"});
  CHECK(labels(5)[1] == "t = 0.025, 0.05, 0.075 s");
  CHECK(labels(11)[1] == "every 0.01 s");
  CHECK(labels(50).size() == 3);  // more poses than samples: each sample once
}

TEST_CASE("start and end are solid, poses between them thin") {
  const Run run = run_of("3rrr.yaml");
  std::map<std::string, PlotShape> links;
  const Plot picture = plot_paths({{"run", &run.result, &run.mechanism}}, {.poses = 3});
  for (const PlotShape& shape : picture.panels[0].shapes)
    if (!shape.label.empty()) links[shape.label.substr(0, 3)] = shape;
  REQUIRE(links.size() == 3);
  for (const auto& [label, shape] : links) CHECK(shape.pen.dashes.empty());
  CHECK(links["t ="].pen.width < 0.5 * links["sta"].pen.width);
  CHECK(links["t ="].pen.width < 0.5 * links["end"].pen.width);
  CHECK(lightness(links["sta"].pen.colour) > lightness(links["end"].pen.colour) + 15);  // seen in a grey print
}

TEST_CASE("runs side by side have frames of one size and one scale") {
  const Run one = run_of("3rrr.yaml"), two = run_of("3rrr-redistributed.yaml");
  const std::vector<PlotRun> runs = {{"one", &one.result, &one.mechanism}, {"two", &two.result, &two.mechanism}};
  const Plot picture = plot_paths(runs, {.poses = 2, .is_side_by_side = true});
  REQUIRE(picture.panels.size() == 2);
  CHECK(picture.panels[0].heading == "one");
  CHECK_FALSE(picture.panels[1].legend);  // it would be the same
  const PlotPage page = resolve_page_size(picture, {});
  const std::string script = gnuplot_script(picture, page);
  const std::vector<AxisRange> x = ranges_in(script, "set xrange"), y = ranges_in(script, "set yrange");
  const PageLayout layout = compute_layout(picture, page);
  REQUIRE(x.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const PanelLayout& place = layout.panels[i];
    CHECK(x[i].low == x[0].low);
    CHECK(x[i].high == x[0].high);
    CHECK(
        (x[i].high - x[i].low) / (place.right - place.left) ==
        doctest::Approx((y[i].high - y[i].low) / (place.bottom - place.top)).epsilon(1e-6));  // nine digits are written
    CHECK(place.right <= page.width);
    CHECK(place.bottom < page.height);
  }
  CHECK(layout.panels[0].right < layout.panels[1].left);
  CHECK(layout.panels[0].top == layout.panels[1].top);
  const Plot overlaid = plot_paths(runs, {.poses = 2});
  REQUIRE(overlaid.panels.size() == 1);
  CHECK(overlaid.panels[0].shapes.front().pen.colour != overlaid.panels[0].shapes.back().pen.colour);
  // four runs fill two rows
  CHECK(plot_paths({runs[0], runs[1], runs[0], runs[1]}, {.is_side_by_side = true}).columns == 2);
}

TEST_CASE("everything that is drawn lies within the frame") {
  for (const char* spec : {"slider-crank.yaml", "rr-balanced.yaml", "scara-design.yaml", "rolling-disc.yaml"}) {
    CAPTURE(spec);
    const Run run = run_of(spec);
    const Plot picture = plot_paths({{"run", &run.result, &run.mechanism}}, {.poses = 3});
    const std::string script = gnuplot_script(picture, {});
    const AxisRange x = ranges_in(script, "set xrange").front(), y = ranges_in(script, "set yrange").front();
    for (const PlotShape& shape : picture.panels[0].shapes)
      for (const std::vector<PlotPoint>& piece : shape.pieces)
        for (const PlotPoint& p : piece) {
          CHECK(p.x >= x.low);
          CHECK(p.x <= x.high);
          CHECK(p.y >= y.low);
          CHECK(p.y <= y.high);
        }
  }
}

TEST_CASE("a payload is drawn while it is carried, with an area that follows its mass") {
  Run run = run_of("5r.yaml", 11);
  run.mechanism.attachments.clear();
  const double duration = run.result.time[10];
  Attachment cargo{.name = "cargo", .kind = AttachmentKind::payload, .body = run.mechanism.tool->body, .mass = 1};
  cargo.from = 0.3 * duration, cargo.until = 0.7 * duration;
  run.mechanism.attachments = {cargo};
  const Projection plane = projection_by_name("xy");
  const DrawingScale scale = scale_of(run, plane);
  const auto width_at = [&](Eigen::Index row) {
    const auto masses = select(draw_pose(run.mechanism, run.result, row, plane, scale), DrawingPart::mass);
    return masses.empty() ? 0.0 : distance(masses[0].points[0], masses[0].points[1]);
  };
  CHECK(width_at(0) == 0);
  CHECK(width_at(10) == 0);
  const double width = width_at(5);
  CHECK(width > 0);
  run.mechanism.attachments[0].mass = 0.25;
  CHECK(width_at(5) == doctest::Approx(width / 2));
}

TEST_CASE("a run is not drawn with another mechanism") {
  const Run arm = run_of("spatial-rrr.yaml", 11), crank = run_of("slider-crank.yaml", 11);
  CHECK_THROWS_AS(plot_paths({{"run", &arm.result, &crank.mechanism}}, {.poses = 1}), std::invalid_argument);
  CHECK_THROWS_AS(plot_paths({{"run", &arm.result}}, {.poses = 1}), std::invalid_argument);
  CHECK_THROWS_WITH_AS(plot_paths({{"run", &crank.result}}, {.projection = "isometric"}),
                       "run is planar: it has no view isometric", std::invalid_argument);
}
