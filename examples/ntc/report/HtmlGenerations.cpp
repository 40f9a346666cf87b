// SPDX-License-Identifier: MIT
#include "report/HtmlGenerations.h"

#include "Output.h"
#include "report/Generations.h"
#include "report/HtmlTable.h"

namespace openntc::report {

using tool::Format;

std::string WriteGenerations(const ReportRecord& report, const DeviceRecord& device) {
    const std::vector<const CaseRecord*> cases = ListGenerations(report, device.name);
    if (cases.empty())
        return {};
    Table table({"<case", "generation", "ns per texel, median (quartiles)",
                 "by generation 1, median (quartiles)", "PSNR source, dB", "PSNR FP32, dB", "worst LSB FP32",
                 "memory, KiB"});
    for (const CaseRecord* c : cases) {
        const Spread& ratio = c->againstGeneration1;
        table.Add({DescribeShared(*c), std::to_string(GetGenerationOfNetwork(c->network)),
                   DescribeTime(c->time),
                   ratio.repeats == 0
                       ? "–"
                       : Format("%.3f (%.3f – %.3f)", ratio.median, ratio.lowerQuartile, ratio.upperQuartile),
                   Number(c->accuracy.psnrSource, 2), Number(c->accuracy.psnrFp32, 2),
                   Number(c->accuracy.worstLsbFp32, 3),
                   Format("%.1f", static_cast<double>(c->memoryBytes) / 1024)});
    }
    return "<h3>Generations of files at equal bits per pixel</h3>\n" + table.Take() +
           "<p class=small>Ratios are taken repeat by repeat: the generations took turns. FP8 modes use the "
           "set's FP8 network.</p>\n";
}

} // namespace openntc::report
