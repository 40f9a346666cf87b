// SPDX-License-Identifier: MIT
#include "report/ChartScript.h"
#include "report/HtmlTraining.h"

#include "Output.h"

#include <algorithm>
#include <cmath>

namespace openntc::report {

using tool::Format;

void DrawTraining(ChartScript& script, const ReportRecord& report) {
    double least = INFINITY, most = 0.0;
    std::string plots;
    std::size_t count = 0;
    for (const TrainingRecord& record : report.training) {
        const std::vector<double>& seconds = GetChartSeconds(record);
        std::string rows;
        for (std::size_t i = 0; i < seconds.size(); ++i) {
            if (!(seconds[i] > 0.0) || !std::isfinite(record.psnr[i]))
                continue;
            rows += Format("%.6g %.4f\n", seconds[i], record.psnr[i]);
            least = std::min(least, seconds[i]);
            most = std::max(most, seconds[i]);
        }
        if (rows.empty())
            continue;
        plots += (plots.empty() ? "" : ", ") + script.MakeBlock(rows) +
                 Format(" using 1:2 with linespoints pt 7 ps 0.8 lw 2 lc rgb '%s' title ",
                        kColors[count++ % kColorCount]) +
                 QuoteLabel(DescribeTrainer(record));
    }
    if (plots.empty())
        return;
    const TrainingRecord& first = report.training.front();
    constexpr int kHeight = 480;
    script.Begin("training",
                 Format("Encoding %s, %d x %d, %d channels, %g bits per pixel", first.material.c_str(),
                        first.width, first.height, first.channels, first.bitsPerPixel),
                 "A curve for each kernel of the processor (one thread, its own seconds) and each device "
                 "(seconds of the "
                 "clock). A point is a whole encoding, refinement and evaluation in it; the next one has "
                 "twice the steps. "
                 "Further left is faster, further up better.",
                 kHeight);
    script.Add(Format("set logscale x\nset xlabel 'seconds of the processor; of devices: of the clock "
                      "(logarithmic)'\nset ylabel 'PSNR, dB'\nset xrange [%g:%g]\n",
                      least / 1.3, most * 1.3) +
               MakeTics("x", least, most) + "set key right bottom\nplot " + plots + "\n");
}

} // namespace openntc::report
