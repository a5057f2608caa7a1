//! Examples at the end of each command's help.

pub(super) const PACK: &str = "\
Examples:
  mesocrete pack --fraction 0.4                              a 150 mm cube, with its page
  mesocrete pack SPEC.toml --seed 7 -o model.json            a packing of your own
  mesocrete pack -o deck.inp --analysis compression          from nothing to a deck of a test";

pub(super) const MESH: &str = "\
Examples:
  mesocrete mesh model.json -o mesh.vtu --element-size-mm 2
  mesocrete mesh model.json -o mesh.msh --method lattice     interfaces without steps
  mesocrete mesh model.json -o deck.inp --analysis compression";

pub(super) const SOLVE: &str = "\
Examples:
  mesocrete solve model.json -o out                          compression of a saved model
  mesocrete solve SPEC.toml -o out --test tension            packs first
  mesocrete solve model.json -o out --resume                 goes on from a checkpoint";

pub(super) const DEVICES: &str = "\
Examples:
  mesocrete devices                                          what --device can take
  mesocrete devices --check                                  compares each with the processor";

pub(super) const STUDY: &str = "\
Example of a STUDY.toml:
  spec = \"SPEC.toml\"
  outputs = [\"model.json\"]
  [over]
  seed = [1, 2, 3]
  fraction = [0.3, 0.4]

Run it:
  mesocrete study STUDY.toml -o study --jobs 2

On a cluster:
  mesocrete study STUDY.toml -o study --slurm > study.sbatch    the script of a Slurm array
  mesocrete study STUDY.toml -o study --collect                 the tables, at any time

Exit codes: 0 every case of this process is done; 1 one has failed, or with --collect is left; 130 stopped by a signal.";

pub(super) const DATASET: &str = "\
Examples:
  mesocrete dataset SPEC.toml -n 100 -o volumes.zarr --shape 64 --what phase,grain
  mesocrete dataset SPEC.toml -n 100 -o volumes.h5 --over ranges.toml    ranges.toml: fraction = { low = 0.2, high = 0.4 }";

pub(super) const FIT: &str = "\
Examples:
  mesocrete fit measured.csv SPEC.toml -o fit                the mortar of a measured curve, over three packings
  mesocrete fit measured.csv SPEC.toml --materials C30.toml  starts from the materials of a class";

pub(super) const CHECK: &str = "\
Example:
  mesocrete check model.json";

pub(super) const REPORT: &str = "\
Examples:
  mesocrete report model.json -o model.html                  one page to look at
  mesocrete report model.json -o figures.json                the statistics alone
  mesocrete report model.json --cite                         a paragraph for a paper";

pub(super) const CONVERT: &str = "\
Examples:
  mesocrete convert model.json -o model.step                 a solid per aggregate, for CAD
  mesocrete convert model.json -o grains.stl -o grains.csv";

pub(super) const IMAGE: &str = "\
Examples:
  mesocrete image model.json -o labels.tif --voxel-size-mm 0.5
  mesocrete image model.json -o ids.npy --what grain
  mesocrete image model.json -o cut.png --section z=75";

pub(super) const IMPORT: &str = "\
Examples:
  mesocrete import scan.tif --voxel-size-mm 0.1              0 is mortar, every other label a grain or a phase
  mesocrete import phases.npy --aggregate 1,2 -o model.json  core and ITZ are the aggregates' phase
  mesocrete import ids.vti --mortar=-1 -o model.json         ids as mesocrete's own images have them
  mesocrete mesh model.json -o model.inp --element-size-mm 1";

pub(super) const EFFECTIVE: &str = "\
Examples:
  mesocrete effective model.json -o out                      diffusivity, impermeable aggregates
  mesocrete effective model.json --what all --phases p.toml  all properties, with values of your own
  mesocrete effective model.json --what stiffness --eigenstrain mortar=-4e-4
  mesocrete effective model.json --axes x --voxel-size-mm 1  one axis, larger voxels
  mesocrete effective scan.tif --phases labels.toml          a label volume; [diffusivity] has 0 = 1.0 and so on";

pub(super) const INIT: &str = "\
Examples:
  mesocrete init                                             SPEC.toml of the default specimen
  mesocrete init en-cube-150 -o cube.toml                    a specimen of a standard
  mesocrete init --materials C30 --rock granite              MATERIALS.toml, with the source of each value";

pub(super) const RECIPES: &str = "\
Example:
  mesocrete recipes | grep cylinder";

pub(super) const SCHEMA: &str = "\
Example:
  mesocrete schema > spec.schema.json";

pub(super) const COMPLETIONS: &str = "\
Examples:
  mesocrete completions bash > ~/.local/share/bash-completion/completions/mesocrete
  mesocrete completions zsh > ~/.zfunc/_mesocrete
  mesocrete completions fish > ~/.config/fish/completions/mesocrete.fish
  mesocrete completions powershell >> $PROFILE";

pub(super) const MAN: &str = "\
Example:
  mesocrete man ~/.local/share/man/man1";
