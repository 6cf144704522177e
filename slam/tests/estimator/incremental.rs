//! The growing problem against the whole one: solutions and marginals after every step, by dense algebra.

use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use vantage_dataset::Seed;
use vantage_slam::incremental::{Place, Term, Tree};

/// A linear problem as it should be: all terms, solved at once.
#[derive(Default)]
struct Dense {
    dims: BTreeMap<usize, usize>,
    terms: BTreeMap<usize, Term>,
}

impl Dense {
    fn starts(&self) -> BTreeMap<usize, usize> {
        let mut next = 0;
        let start = |(&variable, dim): (&usize, &usize)| {
            next += dim;
            (variable, next - dim)
        };
        self.dims.iter().map(start).collect()
    }

    /// The solution and its covariance.
    fn solve(&self) -> (DVector<f64>, DMatrix<f64>) {
        let (starts, n) = (self.starts(), self.dims.values().sum());
        let (mut hessian, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for term in self.terms.values() {
            let mut whole = DMatrix::zeros(term.constant.len(), n);
            for (variable, jacobian) in term.variables.iter().zip(&term.jacobians) {
                whole.columns_mut(starts[variable], jacobian.ncols()).copy_from(jacobian);
            }
            hessian += whole.tr_mul(&whole);
            gradient += whole.tr_mul(&term.constant);
        }
        let covariance = hessian.cholesky().unwrap().inverse();
        (-&covariance * gradient, covariance)
    }

    fn check(&self, tree: &Tree) {
        let (solution, covariance) = self.solve();
        for (&variable, &start) in &self.starts() {
            let dim = self.dims[&variable];
            let got = DVector::from_column_slice(tree.solution(variable));
            let error = (got - solution.rows(start, dim)).amax();
            assert!(error < 1e-9, "variable {variable}: {error}");
            let got = tree.covariance(variable).unwrap();
            let expected = covariance.view((start, start), (dim, dim));
            let error = DMatrix::from_fn(dim, dim, |i, j| got[(i, j)] - expected[(i, j)]).amax();
            assert!(error < 1e-9, "covariance of variable {variable}: {error}");
        }
    }
}

#[test]
fn every_step_of_a_loop_has_the_solution_and_the_marginals_of_the_whole_problem() {
    let mut stream = Seed(3).stream("incremental", 0);
    let (mut tree, mut dense) = (Tree::default(), Dense::default());
    let mut random = |rows: usize, columns: usize| DMatrix::from_fn(rows, columns, |_, _| stream.normal());
    let add = |tree: &mut Tree, dense: &mut Dense, term: Term| {
        let index = tree.add_term(term.clone());
        dense.terms.insert(index, term);
        index
    };
    let bias = tree.add_variable(2, Place::Shared);
    dense.dims.insert(bias, 2);
    let prior = Term {
        variables: vec![bias],
        jacobians: vec![DMatrix::identity(2, 2)],
        constant: DVector::from_element(2, 0.3),
    };
    add(&mut tree, &mut dense, prior);
    let (steps, objects) = (40, 7);
    let mut poses: Vec<usize> = Vec::new();
    let mut seen: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
    for step in 0..steps {
        let pose = tree.add_variable(3, Place::Chain);
        dense.dims.insert(pose, 3);
        let mut variables = vec![pose];
        variables.extend(poses.last());
        variables.push(bias);
        let jacobians = variables.iter().map(|v| random(4, if *v == bias { 2 } else { 3 })).collect();
        let constant = random(4, 1).column(0).into_owned();
        add(&mut tree, &mut dense, Term { variables, jacobians, constant });
        poses.push(pose);
        // Round twice, so that each object is seen again when it has long been out of view.
        let object = step / 3 % objects;
        let variables = *seen.entry(object).or_insert_with(|| {
            let made = [3, 5].map(|dim| (tree.add_variable(dim, Place::Object(object)), dim));
            dense.dims.extend(made);
            let jacobians = made.map(|(_, dim)| random(8, dim)).to_vec();
            let variables = made.map(|(variable, _)| variable);
            let constant = random(8, 1).column(0).into_owned();
            add(&mut tree, &mut dense, Term { variables: variables.to_vec(), jacobians, constant });
            variables
        });
        let jacobians = vec![random(4, 3), random(4, 3), random(4, 5)];
        let constant = random(4, 1).column(0).into_owned();
        let view = Term { variables: vec![pose, variables[0], variables[1]], jacobians, constant };
        let index = add(&mut tree, &mut dense, view.clone());
        if step % 5 == 4 {
            let jacobians = view.jacobians.iter().map(|j| j * 1.3).collect();
            let changed = Term { jacobians, ..view };
            tree.replace_term(index - 3, dense.terms[&(index - 3)].clone());
            tree.replace_term(index, changed.clone());
            dense.terms.insert(index, changed);
        }
        tree.factorize().unwrap();
        tree.solve(0.0);
        dense.check(&tree);
    }
    for object in [0, 4] {
        for term in tree.remove_object(object) {
            dense.terms.remove(&term);
        }
        seen[&object].iter().for_each(|variable| {
            dense.dims.remove(variable);
        });
    }
    tree.factorize().unwrap();
    tree.solve(0.0);
    dense.check(&tree);
}
