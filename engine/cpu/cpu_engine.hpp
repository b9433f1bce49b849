// The CPU engine: the six stages on a thread pool.
#pragma once

#include "cpu/cpu_clipper.hpp"
#include "engine.hpp"
#include "result/result_builder.hpp"

namespace votess::cpu {

class CpuEngine : public Engine {
public:
    // The clipper and its threads may serve another engine between the runs of this one.
    explicit CpuEngine(CpuClipper& clipper) : clipper_(clipper) {}

    void upload(const Job& job) override;
    void sort() override;
    void knn() override;   // the search structure; candidates are pulled while clipping
    void clip() override;  // decides uncertain signs exactly on the spot
    void fallback() override;
    void download(detail::Result& result) override;

private:
    CpuClipper& clipper_;
    Job job_;
    Progress progress_;
    ResultBuilder result_;
};

}  // namespace votess::cpu
