// Returns whether a row of the chunk fits into the rows out, which hold `capacity` entries.
#ifndef VOTESS_DOWNLOAD_ROW_FITS_GLSL
#define VOTESS_DOWNLOAD_ROW_FITS_GLSL

bool row_fits(uint base, uint offset, uint length, uint capacity) {
    return base <= capacity && offset <= capacity - base && length <= capacity - base - offset;
}

#endif
