// Cooperative matrices of 16 rows and columns: halves are multiplied, f32 added up.

enable f16;
enable wgpu_cooperative_matrix;

const EDGE = 16u;

alias Weights = coop_mat16x16<f16, A>;
alias Pixels = coop_mat16x16<f16, B>;
alias Sums = coop_mat16x16<f32, C>;

