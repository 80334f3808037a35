#include "balance/report/page_assets.hpp"

#ifdef BALANCE_PAGE_BUNDLE
// The assembler takes the files as they are, which is far quicker than compiling lists of numbers.
#define BALANCE_EMBED(name, file)                                                                                    \
  __asm__(".pushsection .rodata\n.global " #name "_begin\n" #name "_begin:\n.incbin \"" BALANCE_PAGE_BUNDLE "/" file \
          "\"\n.global " #name "_end\n" #name "_end:\n.byte 0\n.popsection\n");                                      \
  extern "C" const char name##_begin[];                                                                              \
  extern "C" const char name##_end[];

BALANCE_EMBED(balance_page_planar, "planar.js")
BALANCE_EMBED(balance_page_spatial, "spatial.js")
BALANCE_EMBED(balance_page_style, "page.css")
#endif

namespace balance {

HtmlReportAssets page_assets() {
#ifdef BALANCE_PAGE_BUNDLE
  return {{balance_page_planar_begin, balance_page_planar_end},
          {balance_page_spatial_begin, balance_page_spatial_end},
          {balance_page_style_begin, balance_page_style_end}};
#else
  return {};
#endif
}

}  // namespace balance
