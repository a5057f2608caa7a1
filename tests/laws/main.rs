//! Material laws at one point against closed forms, the decks' curves and OOFEM.

mod cdp;
mod cdpm2;
mod con2dpm;
mod deck;
mod meso;
mod registers;
mod safety;
mod subject;
