#pragma once
/// The page's scripts and styles, bundled when the program was built. Private to the page.

#include <string_view>

namespace balance {

struct HtmlReportAssets {
  std::string_view planar_script, spatial_script, style;  ///< UTF-8; all empty: built without them
};

HtmlReportAssets page_assets();

}  // namespace balance
