// Reports as one HTML file: headings, tables, bar charts and images, nothing loaded from
// elsewhere.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/io/bytes.h"

namespace engram {

// "1 task", "2 tasks".
std::string counted(std::size_t count, std::string_view what);

// Readable in light and dark, and on screens of any width.
class HtmlReport {
 public:
  explicit HtmlReport(std::string_view title);

  void heading(std::string_view text);
  void paragraph(std::string_view text);
  // Without titles of columns, rows are names and values. Cells that look like numbers are aligned
  // to the right.
  void table(const std::vector<std::string>& header,
             const std::vector<std::vector<std::string>>& rows);

  struct RateBar {
    std::string label;
    double value = 0;  // 0 to 1
    double mark = -1;  // a second value, shown as a line across the bar; below 0: none
    std::string group;
    double low = -1;  // interval of the value, shown as a thin line; below 0: none
    double high = -1;
  };
  // Horizontal bars of rates, colours by group.
  void bars(const std::vector<RateBar>& bars);

  struct CurvePoint {
    double x = 0;
    double y = 0;  // 0 to 1
    double low = 0;
    double high = 1;
  };
  struct Curve {
    std::string name;
    std::vector<CurvePoint> points;
  };
  // Rates over a quantity, with their intervals. logarithmic: the axis of the quantity x is that of
  // log(1 + x). mark: a rate that is shown as a line; below 0: none.
  struct CurveAxes {
    std::string quantity;
    bool logarithmic = false;
    double mark = -1;
  };
  void curves(const std::vector<Curve>& curves, const CurveAxes& axes);
  void image(std::string_view caption, std::span<const std::byte> png);

  // The whole document.
  std::string text() const;

 private:
  std::string title_;
  std::string body_;
};

}  // namespace engram
