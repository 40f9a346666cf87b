// SPDX-License-Identifier: MIT
#include "report/HtmlTraining.h"

#include "Output.h"
#include "report/HtmlTable.h"

namespace openntc::report {

using tool::Format;

const std::vector<double>& GetChartSeconds(const TrainingRecord& record) {
    return record.threads > 0 ? record.processorSeconds : record.seconds;
}

std::string DescribeTrainer(const TrainingRecord& record) {
    return record.threads > 0
               ? record.kernel
               : record.device + Format(" (%s, %d texels a step)", record.kernel.c_str(), record.batchTexels);
}

std::string WriteTraining(const ReportRecord& report,
                          const std::function<std::string(const std::string&)>& getFigure) {
    if (report.training.empty())
        return {};
    const TrainingRecord& first = report.training.front();
    std::string html = "<h2 id=training>Encoding: what accuracy costs in time</h2>\n<p>" +
                       tool::EscapeMarkup(first.material) +
                       Format(", %d × %d, %d channels, %g bits per pixel, medium network, seed 1: whole "
                              "encodings with more and more steps (of 4096 texels).</p>\n",
                              first.width, first.height, first.channels, first.bitsPerPixel) +
                       getFigure("training");
    Table table(
        {"<kernel or device", "steps", "seconds of the clock", "of the processor", "PSNR, dB", "<remark"},
        true);
    for (const TrainingRecord& record : report.training) {
        for (std::size_t i = 0; i < record.steps.size(); ++i)
            table.Add({DescribeTrainer(record), Format("%d", record.steps[i]), Short(record.seconds[i]),
                       Short(record.processorSeconds[i]), Number(record.psnr[i], 2), ""});
        if (record.steps.empty())
            table.Add({record.device, "", "", "", "", record.skipped});
    }
    return html + table.Take();
}

} // namespace openntc::report
