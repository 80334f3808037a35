#pragma once
/// The front door: YAML text in, a complete and validated Study out. The language is described in docs/spec.md.

#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/spec_expressions.hpp"
#include "balance/motion/study/study.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace balance {

namespace specification {
struct YamlNode;
}

struct ReadOptions {
  /// Parameters to override, name and value; the value may be an expression over the other parameters.
  std::vector<std::pair<std::string, std::string>> set;
};

/// @param text the spec, UTF-8, at most 4 MiB
/// @param file_name what messages call it; files that the spec names are looked for in its folder
/// @throws SpecError with everything that is wrong, in the order of the document
Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options = {});

/// A spec's text, parsed once for many readings with other parameters. Never changed; copies share what was parsed.
class SpecDocument {
 public:
  /// Reading reports a text that is no YAML.
  explicit SpecDocument(std::string text);
  const std::string& text() const { return text_; }
  /// Nothing if there is something wrong.
  const specification::YamlNode* root() const { return root_.get(); }

 private:
  std::string text_;
  std::shared_ptr<const specification::YamlNode> root_;
};

/// @throws SpecError as above
Study read_spec(const SpecDocument& document, const std::string& file_name, const ReadOptions& options = {});

/// @throws SystemError if the file cannot be read; SpecError as above
Study read_spec_file(const std::string& path, const ReadOptions& options = {});

/// The same with the spec's free numbers still free: read_spec is its `start`. Its `at` throws std::invalid_argument for a vector
/// of another length than start.free_numbers. A direction of no length is x there, a quaternion of no length no rotation.
/// @throws SpecError, SystemError as above
DesignSpace read_design_space(const std::string& text, const std::string& file_name, const ReadOptions& options = {});
DesignSpace read_design_space_file(const std::string& path, const ReadOptions& options = {});

/// What `minimize` says, from the command line.
/// @param text YAML: `added-mass`, `{rms: torque, along: cycloid}`, a list of such
/// @throws SpecError whose file is `--minimize`
std::vector<ObjectiveTerm> read_objective(const std::string& text, const Study& study);

/// A pose, from the command line, in the spec's units.
/// @param text `A1=0.3,A2=0.5` (joint coordinates), or YAML as in a trajectory, with braces or without: `tool: [0.1, 0.2], angle: 0`
/// @throws SpecError whose file is `--at`
PoseTarget read_pose(const std::string& text, const Study& study);

/// Rates or accelerations of joint coordinates, in the spec's units of length and angle and in seconds.
/// @param text `A1=1,A2=-2` @param option what messages call it
/// @throws SpecError whose file is the option
std::vector<CoordinateValue> read_coordinate_rates(const std::string& text, const char* option, const Study& study);

/// A spec together with how far its numbers may be off.
struct TolerancedDesignSpace {
  DesignSpace space;
  Tolerances tolerances;  ///< parameters first, else in the order of reading; empty if the spec says nothing of them
};

/// @throws SpecError, SystemError as read_design_space
TolerancedDesignSpace read_toleranced_space(const std::string& text, const std::string& file_name,
                                            const ReadOptions& options = {});
TolerancedDesignSpace read_toleranced_space_file(const std::string& path, const ReadOptions& options = {});

// What a spec says about its numbers.

/// @param options those that the space was read with
SpecNumberTexts read_spec_number_texts(const DesignSpace& space, const ReadOptions& options = {});

}  // namespace balance
