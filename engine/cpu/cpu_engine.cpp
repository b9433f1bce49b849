#include "cpu/cpu_engine.hpp"

namespace votess::cpu {

void CpuEngine::upload(const Job& job) {
    job_ = job;
    progress_ = Progress(job.options.progress);
    clipper_.begin(job);
}

void CpuEngine::sort() {
    progress_.report(0);
    clipper_.sort();
}

void CpuEngine::knn() {
    clipper_.build_search();
}

void CpuEngine::clip() {
    result_.begin(job_, clipper_.pool());
    clipper_.clip_all(result_, {0.05, 0.95});
}

// Exact arithmetic has decided every sign and every search has run to its proof: no cell is left over.
void CpuEngine::fallback() {}

void CpuEngine::download(detail::Result& result) {
    clipper_.set_empty(result_);
    result_.set_duplicates(clipper_.duplicate_of(), clipper_.pool());
    result_.finish(result, clipper_.pool());
    result.stats.device = "cpu";
    clipper_.end();
    progress_.report(1);
    job_ = {};
}

}  // namespace votess::cpu
