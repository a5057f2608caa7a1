//! Do two convex bodies share a point; and how far apart are they.
