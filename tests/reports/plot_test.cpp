#include "balance/interface/reports/plot.hpp"
#include "balance/interface/reports/gnuplot.hpp"
#include "balance/interface/reports/gnuplot_script.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using namespace balance;
using namespace balance::reports;

namespace {

RunResult run_of(const std::string& spec, const std::string& trajectory, int samples = 101) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + spec);
  for (Trajectory candidate : study.trajectories) {
    if (candidate.name != trajectory) continue;
    candidate.samples = samples;
    return simulate(study.mechanism, candidate);
  }
  throw std::invalid_argument(trajectory);
}

const RunResult& bang_bang() {
  static const RunResult result = run_of("3rrr.yaml", "bang-bang");
  return result;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

std::string script_of(const std::vector<std::string>& quantities, const std::string& label = "run") {
  return gnuplot_script(plot_over_time({{label, &bang_bang()}}, quantities, VectorView::magnitude, Abscissa::seconds),
                        {});
}

}  // namespace

TEST_CASE("a plot draws round-off as zero (D2)") {
  RunResult result = run_of("planar-rrr.yaml", "cycloid");
  result.shaking_force.array() += 1e-15;
  for (const char* name : {"shaking_force", "shaking_force.x", "com_acceleration", "com_velocity"}) {
    const auto quantity = find_plot_quantity(result, name, VectorView::both);
    REQUIRE(quantity.has_value());
    for (const PlotCurve& curve : quantity->curves) CHECK(curve.values.cwiseAbs().maxCoeff() == 0);
  }
  CHECK(find_plot_quantity(result, "shaking_moment", VectorView::both)->curves.front().values.cwiseAbs().maxCoeff() >
        1);
}

TEST_CASE("every quantity of a run can be drawn, by every name that the list has") {
  for (const char* spec : {"3rrr.yaml", "scara.yaml"}) {
    const RunResult result = run_of(spec, "cycloid", 11);
    const std::vector<std::string> names = list_plot_names(result);
    CHECK(names.size() > 60);
    for (const std::string& name : names) {
      CAPTURE(name);
      const auto quantity = find_plot_quantity(result, name, VectorView::both);
      REQUIRE(quantity.has_value());
      for (const PlotCurve& curve : quantity->curves) CHECK(curve.values.size() == 11);
    }
  }
  CHECK_FALSE(find_plot_quantity(bang_bang(), "shaking_force.z", VectorView::both).has_value());
  CHECK_FALSE(find_plot_quantity(bang_bang(), "torque[A9]", VectorView::both).has_value());
}

TEST_CASE("a vector's magnitude is the root of its components' squares") {
  const auto values = [&](const std::string& name) {
    return find_plot_quantity(bang_bang(), name, VectorView::magnitude)->curves.front().values;
  };
  const VectorX x = values("joint_force[B1].x"), y = values("joint_force[B1].y"), size = values("joint_force[B1]");
  CHECK((size.cwiseAbs2() - x.cwiseAbs2() - y.cwiseAbs2()).norm() <= 1e-12 * size.squaredNorm());
  CHECK(find_plot_quantity(bang_bang(), "shaking_force", VectorView::magnitude)->not_negative);
  CHECK_FALSE(find_plot_quantity(bang_bang(), "shaking_force.x", VectorView::magnitude)->not_negative);
  CHECK(find_plot_quantity(bang_bang(), "shaking_force", VectorView::both)->curves.size() == 3);
}

TEST_CASE("members of a quantity keep their column") {
  const VectorX a2 = find_plot_quantity(bang_bang(), "torque[A2]", VectorView::magnitude)->curves.front().values;
  CHECK(a2 == bang_bang().torque.col(1));
  const auto all = find_plot_quantity(bang_bang(), "torque", VectorView::magnitude);
  REQUIRE(all->curves.size() == 3);
  CHECK(all->curves[1].label == "A2");
  CHECK(all->curves[1].values == a2);
}

TEST_CASE("bang-bang jumps in the middle and smooth laws nowhere, however many samples there are") {
  for (const int samples : {11, 101, 1001}) {
    CAPTURE(samples);
    CHECK(find_sampled_jumps(run_of("3rrr.yaml", "bang-bang", samples)) ==
          std::vector<Eigen::Index>{(samples - 1) / 2});
    CHECK(find_sampled_jumps(run_of("3rrr.yaml", "cycloid", samples)).empty());
    CHECK(find_sampled_jumps(run_of("spatial-rrr.yaml", "cycloid", samples)).empty());
  }
}

TEST_CASE("a jump is drawn upright, from the value before it to the value after it") {
  const std::vector<Eigen::Index> jumps = find_sampled_jumps(bang_bang());
  const VectorX values = bang_bang().com_acceleration.col(0);
  const std::vector<PlotPoint> points = trace_values(bang_bang().time, values, jumps);
  REQUIRE(points.size() == 102);
  CHECK(points[50].x == points[51].x);
  // P3 eq. 35: plus and minus the same acceleration. The value before is extrapolated from a constant.
  CHECK(points[50].y == doctest::Approx(values[0]).epsilon(1e-9));
  CHECK(points[51].y == doctest::Approx(-values[0]).epsilon(1e-9));
  // What does not jump gets no second point.
  CHECK(trace_values(bang_bang().time, bang_bang().com_position.col(0), jumps).size() == 101);
}

TEST_CASE("the value before a jump of the moment is its limit from the left") {
  const RunResult fine = run_of("3rrr.yaml", "bang-bang", 1001);
  const std::vector<PlotPoint> points = trace_values(fine.time, fine.shaking_moment.col(0), find_sampled_jumps(fine));
  REQUIRE(points.size() == 1002);
  CHECK(points[500].y == doctest::Approx(47.83).epsilon(2e-4));  // docs/errata.md
  CHECK(points[501].y == doctest::Approx(58.1842).epsilon(1e-5));
}

TEST_CASE("thinning keeps ends, extremes and order") {
  std::vector<PlotPoint> points;
  for (int i = 0; i < 100000; ++i) points.push_back({i * 1e-5, std::sin(i * 1e-3)});
  points[54321].y = 7;
  points[12345].y = -7;
  const std::vector<PlotPoint> kept = decimate_series(points, 4000);
  CHECK(kept.size() <= 4000);
  CHECK(std::is_sorted(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.x < b.x; }));
  CHECK(kept.front().x == points.front().x);
  CHECK(kept.back().x == points.back().x);
  CHECK(std::any_of(kept.begin(), kept.end(), [](const auto& point) { return point.y == 7; }));
  CHECK(std::any_of(kept.begin(), kept.end(), [](const auto& point) { return point.y == -7; }));
  const std::vector<PlotPoint> path = decimate_path(points, 1000);
  CHECK(path.size() == 1000);
  CHECK(path.back().x == points.back().x);
}

TEST_CASE("no two of the first six pens look alike on a grey printer") {
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(lightness(make_line_style(i, i).colour) < 72);  // dark enough on white
    for (std::size_t j = 0; j < i; ++j) {
      CAPTURE(i);
      CAPTURE(j);
      CHECK(make_line_style(i, i).dashes != make_line_style(j, j).dashes);
    }
    if (i > 0 && i < 3)
      CHECK(lightness(make_line_style(i, i).colour) > lightness(make_line_style(i - 1, i - 1).colour) + 10);
  }
  CHECK(lightness("#000000") == doctest::Approx(0));
  CHECK(lightness("#ffffff") == doctest::Approx(100));
}

TEST_CASE("no text can be a command") {
  CHECK(gnuplot_quoted("\"\\`") == "'\"\\`'");
  CHECK(gnuplot_quoted("'a\"\\`1") == "\"'a\\042\\134\\1401\"");
  CHECK(gnuplot_quoted("a\nb\tc") == "'a\\x0ab\\x09c'");
  CHECK(gnuplot_quoted("µ\xff²\xc2") == "'µ\\xff²\\xc2'");
  CHECK(gnuplot_quoted("a\u202Eb\u2066c") == "'a<U+202E>b<U+2066>c'");
  const std::string script = script_of({"torque"}, "'; system 'touch x'; '`touch x`\n!touch x");
  for (const char* begin : {"\n!", "\nsystem", "\ntouch"}) CHECK(count(script, begin) == 0);
  CHECK(count(script, "output") == 0);  // it names no file
}

TEST_CASE("a script has a panel for each quantity and a line for each curve, and is the same each time") {
  const std::string script = script_of({"torque", "shaking_force"});
  CHECK(count(script, "\nplot ") == 2);
  CHECK(count(script, "with lines") == 4);
  CHECK(count(script, "'torque [N m]'") == 1);
  CHECK(count(script, "'shaking force [N]'") == 1);
  CHECK(count(script, "'time [s]'") == 1);
  CHECK(count(script, "nohead") == 3);  // samples of the legend
  CHECK(script == script_of({"torque", "shaking_force"}));
}

TEST_CASE("runs over each other share a panel, and a legend is not said twice") {
  const RunResult other = run_of("3rrr.yaml", "cycloid");
  const Plot picture = plot_over_time({{"one", &bang_bang()}, {"two", &other}}, {"shaking_force", "shaking_moment"},
                                      VectorView::magnitude, Abscissa::normalised);
  REQUIRE(picture.panels.size() == 2);
  CHECK(picture.panels[0].lines.size() == 2);
  CHECK(picture.panels[0].legend);
  CHECK_FALSE(picture.panels[1].legend);
  CHECK(picture.panels[0].lines[1].points.back().x == 1);
  CHECK(picture.panels[0].lines[1].label == "two");
}

TEST_CASE("curves of different units do not share an axis") {
  const RunResult result = run_of("slider-crank.yaml", "cycloid", 11);
  const std::vector<PlotRun> runs = {{"run", &result}};
  CHECK_THROWS_WITH_AS(plot_over_time(runs, {"joint_position"}, VectorView::magnitude, Abscissa::seconds),
                       "joint_position has different units: name one, such as joint_position[A]",
                       std::invalid_argument);
  const Plot slider = plot_over_time(runs, {"joint_position[S]"}, VectorView::magnitude, Abscissa::seconds);
  CHECK(slider.panels.front().y_label == "joint position S [m]");
  CHECK_THROWS_AS(plot_paths(runs, {.projection = "xz"}), std::invalid_argument);
}

TEST_CASE("on a path a metre is as long upwards as to the right") {
  const Plot picture = plot_paths({{"run", &bang_bang()}}, {});
  for (const double height : {60.0, 150.0}) {
    const PlotPage page{.width = 120, .height = height};
    const std::string script = gnuplot_script(picture, page);
    const PanelLayout place = compute_layout(picture, page).panels.front();
    double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
    REQUIRE(std::sscanf(script.c_str() + script.find("set xrange"), "set xrange [%lf:%lf]", &x0, &x1) == 2);
    REQUIRE(std::sscanf(script.c_str() + script.find("set yrange"), "set yrange [%lf:%lf]", &y0, &y1) == 2);
    const double across = (x1 - x0) / (place.right - place.left), upwards = (y1 - y0) / (place.bottom - place.top);
    CHECK(across == doctest::Approx(upwards).epsilon(1e-6));  // nine digits are written
    CHECK(x0 < -0.1);                                         // the tool's ends are inside
    CHECK(x1 > 0.1);
  }
  CHECK(picture.panels.front().marks.size() == 2);
  CHECK(picture.panels.front().marks[0].points[0].x == doctest::Approx(-0.1));
  CHECK(picture.panels.front().marks[1].points[0].x == doctest::Approx(0.1));
}

TEST_CASE("a PDF's date becomes the epoch, and no byte moves") {
  const std::string pdf = "1 0 obj << /CreationDate (D:20261121155111Z) >> xref";
  CHECK(remove_pdf_date(pdf) == "1 0 obj << /CreationDate (D:19700101000000Z) >> xref");
  CHECK(remove_pdf_date("nothing") == "nothing");
}

TEST_CASE("a phase plane has a pen for every limit, a ring at every switch, and ends below its top") {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/3rrr.yaml");
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = 11;
  trajectory.law.kind = MotionLawKind::time_optimal;
  trajectory.limits = {{"shaking_force", 549.2528818391}, {"shaking_moment", 30}};
  const RunResult result = simulate(study.mechanism, trajectory);
  const Plot picture = plot_phase_plane({{"run", &result}});
  REQUIRE(picture.panels.size() == 1);
  const PlotPanel& panel = picture.panels.front();
  std::vector<std::string> labels;
  double top = 0;
  for (const PlotLine& line : panel.lines) {
    if (!line.label.empty()) labels.push_back(line.label);
    for (const PlotPoint& point : line.points) top = std::max(top, point.y);
  }
  CHECK(labels == std::vector<std::string>{"largest rate within the limits", "shaking_force", "shaking_moment"});
  CHECK(top <= 1.4 * result.phase_plane.path_rate.maxCoeff() * (1 + 1e-12));
  REQUIRE(panel.marks.size() == 1);
  CHECK(panel.marks.front().points.size() == result.optimised_law->switch_times.size());
  CHECK(gnuplot_script(picture, {}) == gnuplot_script(picture, {}));
  const Plot both = plot_phase_plane({{"one", &result}, {"two", &bang_bang()}});
  CHECK(both.panels.front().lines.back().label == "two");
  const RunResult empty;
  CHECK_THROWS_AS(plot_phase_plane({{"run", &empty}}), std::invalid_argument);
}
